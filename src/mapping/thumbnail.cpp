// SPDX-License-Identifier: BSD-3-Clause
#include "thumbnail.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "object_volume.h"

namespace tsg::mapping {

ColorImage makeThumbnail(const SegmentedFrame& view, std::uint16_t segment, int max_side_px) {
  if (!view.frame || !view.segmentation || max_side_px == 0) return {};
  const cv::Mat& image = view.frame->color.image;
  if (view.segmentation->labels.size() != image.size()) return {};
  const cv::Rect tight = findLabel(view.segmentation->labels, segment);
  if (tight.empty()) return {};
  const cv::Size margin(tight.width / 10 + 1, tight.height / 10 + 1);
  const cv::Rect wide = (tight - cv::Point(margin.width, margin.height)) + margin + margin;
  const cv::Mat part = image(wide & cv::Rect({}, image.size()));
  const double scale =
      std::min(1.0, max_side_px / static_cast<double>(std::max(part.cols, part.rows)));
  const cv::Size size(std::max(1, static_cast<int>(part.cols * scale)),
                      std::max(1, static_cast<int>(part.rows * scale)));
  ColorImage thumbnail;
  thumbnail.stamp = view.frame->stamp;
  cv::resize(part, thumbnail.image, size, 0.0, 0.0, cv::INTER_AREA);
  if (view.frame->color.order == ColorOrder::kBgr) {
    cv::cvtColor(thumbnail.image, thumbnail.image, cv::COLOR_BGR2RGB);
  }
  return thumbnail;
}

}  // namespace tsg::mapping
