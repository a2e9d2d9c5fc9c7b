// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "resampling.h"
#include "task_scene_graph/segmentation/image_encoder.h"

namespace tsg::segmentation {
namespace {

cv::Mat blackenOthers(const cv::Mat& crop, const cv::Mat& labels, std::uint16_t keep) {
  cv::Mat masked = cv::Mat::zeros(crop.size(), crop.type());
  for (int v = 0; v < crop.rows; ++v) {
    const std::uint16_t* label = labels.ptr<std::uint16_t>(v);
    const cv::Vec3b* from = crop.ptr<cv::Vec3b>(v);
    cv::Vec3b* to = masked.ptr<cv::Vec3b>(v);
    for (int u = 0; u < crop.cols; ++u) {
      if (label[u] == keep) to[u] = from[u];
    }
  }
  return masked;
}

int scaleLonger(int longer, int shorter, int size_px) {  // truncated, as torchvision's Resize does
  return static_cast<int>(static_cast<std::int64_t>(size_px) * longer / shorter);
}

cv::Mat centerCrop(const cv::Mat& crop, int size_px) {
  const cv::Size resized = crop.cols <= crop.rows
                               ? cv::Size(size_px, scaleLonger(crop.rows, crop.cols, size_px))
                               : cv::Size(scaleLonger(crop.cols, crop.rows, size_px), size_px);
  // Halves are rounded to the even neighbour, as torchvision's CenterCrop does.
  const cv::Point corner(static_cast<int>(std::nearbyint((resized.width - size_px) / 2.0)),
                         static_cast<int>(std::nearbyint((resized.height - size_px) / 2.0)));
  return resizeBicubic(crop, resized, {corner, cv::Size(size_px, size_px)});
}

cv::Mat padToSquare(const cv::Mat& crop, int size_px) {
  const double scale = static_cast<double>(size_px) / std::max(crop.cols, crop.rows);
  const cv::Size resized(std::max(1, static_cast<int>(std::lround(crop.cols * scale))),
                         std::max(1, static_cast<int>(std::lround(crop.rows * scale))));
  cv::Mat square = cv::Mat::zeros(size_px, size_px, crop.type());
  const cv::Rect middle({(size_px - resized.width) / 2, (size_px - resized.height) / 2}, resized);
  resizeBicubic(crop, resized, {{0, 0}, resized}).copyTo(square(middle));
  return square;
}

std::string describeBox(const cv::Rect& box) {
  return std::to_string(box.width) + "x" + std::to_string(box.height) + " at (" +
         std::to_string(box.x) + ", " + std::to_string(box.y) + ")";
}

}  // namespace

std::vector<Batch> planBatches(int num_crops, int max_batch, bool pad) {
  std::vector<Batch> batches;
  int left = num_crops;
  for (; left >= max_batch; left -= max_batch) batches.push_back({max_batch, max_batch});
  while (left > 0) {
    int size = 1;
    while (pad ? size < left : 2 * size <= left) size *= 2;
    size = std::min(size, max_batch);
    batches.push_back({size, std::min(size, left)});
    left -= batches.back().used;
  }
  return batches;
}

cv::Mat cropToSquare(const cv::Mat& image, const cv::Mat& labels, const CropRequest& request,
                     CropFit fit, int size_px) {
  const cv::Rect& box = request.box_px;
  if (box.empty() || (box & cv::Rect({0, 0}, image.size())) != box) {
    throw std::invalid_argument("crop of " + describeBox(box) + " px, expected a box inside " +
                                std::to_string(image.cols) + "x" + std::to_string(image.rows));
  }
  cv::Mat crop = image(box);
  if (request.keep_label != 0) crop = blackenOthers(crop, labels(box), request.keep_label);
  const cv::Size square(size_px, size_px);
  switch (fit) {
    case CropFit::kSquash:
      return resizeBicubic(crop, square, {{0, 0}, square});
    case CropFit::kPad:
      return padToSquare(crop, size_px);
    case CropFit::kCenterCrop:
      break;
  }
  return centerCrop(crop, size_px);
}

}  // namespace tsg::segmentation
