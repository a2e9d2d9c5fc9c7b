// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/image_motion.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace tsg::segmentation {
namespace {

constexpr int kGridColumns = 160;
constexpr int kSmallestGridSide = 24;  // DIS needs some patches of 8 px
constexpr int kMaxResidual_8bit = 24;  // of a pixel that looks the same
constexpr int kCountStep_px = 2;
constexpr double kMinResponse = 0.05;  // of the phase correlation, 1 = a pure shift

cv::Mat makeSmallGrey(const ColorImage& color) {
  const cv::Size size = color.image.size();
  const double scale = std::min(1.0, static_cast<double>(kGridColumns) / size.width);
  const cv::Size grid(std::max(kSmallestGridSide, cvRound(size.width * scale)),
                      std::max(kSmallestGridSide, cvRound(size.height * scale)));
  cv::Mat small;
  cv::resize(color.image, small, grid, 0, 0, cv::INTER_AREA);
  cv::Mat grey;
  cv::cvtColor(small, grey,
               color.order == ColorOrder::kRgb ? cv::COLOR_RGB2GRAY : cv::COLOR_BGR2GRAY);
  return grey;
}

/// Where most of the image moved (now to before), as a flow to start from: a turning camera moves
/// everything farther than the flow would find by itself.
cv::Mat makeInitialFlow(const cv::Mat& now, const cv::Mat& before) {
  cv::Mat one;
  cv::Mat other;
  now.convertTo(one, CV_32FC1);
  before.convertTo(other, CV_32FC1);
  cv::Mat window;
  cv::createHanningWindow(window, now.size(), CV_32FC1);
  double response = 0.0;
  const cv::Point2d shift = cv::phaseCorrelate(one, other, window, &response);
  const bool is_clear = response > kMinResponse && std::abs(shift.x) < 0.5 * now.cols &&
                        std::abs(shift.y) < 0.5 * now.rows;
  const cv::Point2d start = is_clear ? shift : cv::Point2d(0.0, 0.0);
  return {now.size(), CV_32FC2, cv::Scalar(start.x, start.y)};
}

/// Grid positions that the flow leads to.
cv::Mat toOrigins(const cv::Mat& flow) {
  cv::Mat origins(flow.size(), CV_32FC2);
  for (int v = 0; v < flow.rows; ++v) {
    const auto* shift = flow.ptr<cv::Vec2f>(v);
    auto* origin = origins.ptr<cv::Vec2f>(v);
    for (int u = 0; u < flow.cols; ++u) {
      origin[u] = shift[u] + cv::Vec2f(static_cast<float>(u), static_cast<float>(v));
    }
  }
  return origins;
}

cv::Mat findKnown(const cv::Mat& before, const cv::Mat& now, const cv::Mat& origins) {
  cv::Mat moved;
  cv::remap(before, moved, origins, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::Mat residual;
  cv::absdiff(moved, now, residual);
  cv::Mat is_known = residual <= kMaxResidual_8bit;
  for (int v = 0; v < origins.rows; ++v) {
    const auto* origin = origins.ptr<cv::Vec2f>(v);
    auto* known = is_known.ptr<std::uint8_t>(v);
    for (int u = 0; u < origins.cols; ++u) {
      const bool is_inside = origin[u][0] >= -0.5F && origin[u][1] >= -0.5F &&
                             origin[u][0] <= static_cast<float>(origins.cols) - 0.5F &&
                             origin[u][1] <= static_cast<float>(origins.rows) - 0.5F;
      if (!is_inside) known[u] = 0;
    }
  }
  return is_known;
}

}  // namespace

double ImageMotion::computeKnownShare() const {
  if (isEmpty()) return 0.0;
  return static_cast<double>(cv::countNonZero(is_known)) / static_cast<double>(is_known.total());
}

MotionEstimator::MotionEstimator()
    : flow_(cv::DISOpticalFlow::create(cv::DISOpticalFlow::PRESET_ULTRAFAST)) {
  flow_->setUseSpatialPropagation(false);
  flow_->setFinestScale(1);
}

ImageMotion MotionEstimator::update(const ColorImage& color) {
  const cv::Mat now = makeSmallGrey(color);
  const bool is_first = before_.empty() || image_size_px_ != color.image.size();
  ImageMotion motion;
  if (!is_first) {
    cv::Mat flow = makeInitialFlow(now, before_);
    flow_->calc(now, before_, flow);
    const cv::Mat origins = toOrigins(flow);
    motion.is_known = findKnown(before_, now, origins);
    motion.image_size_px = color.image.size();
    // Pixel centres lie at whole numbers plus one half.
    const cv::Scalar scale(static_cast<double>(color.image.cols) / now.cols,
                           static_cast<double>(color.image.rows) / now.rows);
    cv::Mat centers = origins + cv::Scalar(0.5, 0.5);
    cv::multiply(centers, scale, centers);
    motion.origins_px = centers - cv::Scalar(0.5, 0.5);
  }
  before_ = now;
  image_size_px_ = color.image.size();
  return motion;
}

namespace {

/// Row `v` of `labels` moved; each cell of the grid as a whole, by whole pixels.
void moveRow(const cv::Mat& labels, const cv::Mat& origins_px, int v, std::uint16_t* to) {
  const int columns = origins_px.cols;
  const int gv = v * origins_px.rows / labels.rows;
  const double center_v = (gv + 0.5) * labels.rows / origins_px.rows - 0.5;
  const double cell_width = static_cast<double>(labels.cols) / columns;
  const auto* origin = origins_px.ptr<cv::Vec2f>(gv);
  for (int gu = 0, begin = 0; gu < columns; ++gu) {
    const int end = (gu + 1) * labels.cols / columns;
    const int shift_u = cvRound(origin[gu][0] - ((gu + 0.5) * cell_width - 0.5));
    const int from_v = v + cvRound(origin[gu][1] - center_v);
    const bool is_inside = from_v >= 0 && from_v < labels.rows;
    const int first = is_inside ? std::clamp(-shift_u, begin, end) : end;
    const int last = is_inside ? std::clamp(labels.cols - shift_u, first, end) : end;
    std::fill(to + begin, to + first, std::uint16_t{0});
    if (first < last) {
      const auto* from = labels.ptr<std::uint16_t>(from_v) + shift_u;
      std::copy(from + first, from + last, to + first);
    }
    std::fill(to + last, to + end, std::uint16_t{0});
    begin = end;
  }
}

}  // namespace

cv::Mat moveLabels(const cv::Mat& labels, const ImageMotion& motion) {
  cv::Mat moved(labels.size(), CV_16UC1);
  for (int v = 0; v < labels.rows; ++v) {
    moveRow(labels, motion.origins_px, v, moved.ptr<std::uint16_t>(v));
  }
  return moved;
}

Eigen::MatrixXi countCommonPixels(const cv::Mat& labels_a, std::size_t num_a,
                                  const cv::Mat& labels_b, std::size_t num_b) {
  Eigen::MatrixXi counts = Eigen::MatrixXi::Zero(static_cast<Eigen::Index>(num_a) + 1,
                                                 static_cast<Eigen::Index>(num_b) + 1);
  for (int v = 0; v < labels_a.rows; v += kCountStep_px) {
    const auto* a = labels_a.ptr<std::uint16_t>(v);
    const auto* b = labels_b.ptr<std::uint16_t>(v);
    for (int u = 0; u < labels_a.cols; u += kCountStep_px) {
      counts(a[u], b[u]) += kCountStep_px * kCountStep_px;
    }
  }
  return counts;
}

}  // namespace tsg::segmentation
