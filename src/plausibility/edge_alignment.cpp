// SPDX-License-Identifier: BSD-3-Clause
#include "edge_alignment.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

namespace tsg::plausibility {
namespace {

constexpr float kMinJump = 0.08F;      // relative difference of depth between neighbours
constexpr float kMaxGradient = 40.0F;  // one strong colour edge must not outweigh many
constexpr std::size_t kMinImages = 8;
constexpr std::size_t kMinEdges = 1500;
constexpr int kMinShift_px = 3;
constexpr double kMinSignificance = 5.0;
constexpr double kMaxUnshifted = 0.75;

bool isJump(float a_m, float b_m) {
  const float nearer = std::min(a_m, b_m);
  return nearer > 0.0F && std::abs(a_m - b_m) > kMinJump * nearer;
}

bool isDepthEdge(const DepthGrid& grid, int u, int v) {
  const float z_m = grid.at(u, v);
  return isJump(z_m, grid.at(u + 1, v)) || isJump(z_m, grid.at(u, v + 1));
}

/// Larger of the differences to the right and lower neighbour; CV_32FC1 of the grid's size.
cv::Mat computeGradient(const cv::Mat& color, const CameraModel& grid) {
  cv::Mat small;
  cv::resize(color, small, cv::Size(grid.width_px, grid.height_px), 0.0, 0.0, cv::INTER_AREA);
  cv::Mat grey;
  cv::cvtColor(small, grey, cv::COLOR_RGB2GRAY);
  cv::Mat gradient = cv::Mat::zeros(grey.size(), CV_32FC1);
  for (int v = 0; v + 1 < grey.rows; ++v) {
    for (int u = 0; u + 1 < grey.cols; ++u) {
      const int center = grey.at<std::uint8_t>(v, u);
      const int along_u = std::abs(grey.at<std::uint8_t>(v, u + 1) - center);
      const int along_v = std::abs(grey.at<std::uint8_t>(v + 1, u) - center);
      gradient.at<float>(v, u) =
          std::min(kMaxGradient, static_cast<float>(std::max(along_u, along_v)));
    }
  }
  return gradient;
}

}  // namespace

void EdgeAlignment::add(const DepthGrid& depth, const cv::Mat& color) {
  const int width_px = depth.camera.width_px;
  const int height_px = depth.camera.height_px;
  if (width_px < 4 * kRadius_px || height_px < 4 * kRadius_px) return;
  const cv::Mat gradient = computeGradient(color, depth.camera);
  const double mean = cv::mean(gradient)[0];
  ++num_images_;
  for (int v = kRadius_px; v + kRadius_px < height_px; ++v) {
    for (int u = kRadius_px; u + kRadius_px < width_px; ++u) {
      if (!isDepthEdge(depth, u, v)) continue;
      ++num_edges_;
      double* sum = sums_.data();
      for (int dy = -kRadius_px; dy <= kRadius_px; ++dy) {
        const float* row = gradient.ptr<float>(v + dy) + u - kRadius_px;
        for (int i = 0; i < kSide; ++i) *sum++ += static_cast<double>(row[i]) - mean;
      }
    }
  }
}

std::optional<EdgeAlignment::Shift> EdgeAlignment::findShift() const {
  if (num_images_ < kMinImages || num_edges_ < kMinEdges) return std::nullopt;
  const double count = static_cast<double>(sums_.size());
  const double mean = std::accumulate(sums_.begin(), sums_.end(), 0.0) / count;
  double squares = 0.0;
  for (const double sum : sums_) squares += (sum - mean) * (sum - mean);
  const double deviation = std::sqrt(squares / count);
  if (!(deviation > 0.0)) return std::nullopt;
  const auto peak = std::max_element(sums_.begin(), sums_.end());
  const auto index = static_cast<int>(peak - sums_.begin());
  double unshifted = 0.0;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const int i = (kRadius_px + dy) * kSide + kRadius_px + dx;
      unshifted = std::max(unshifted, sums_[static_cast<std::size_t>(i)] - mean);
    }
  }
  return Shift{index % kSide - kRadius_px, index / kSide - kRadius_px, (*peak - mean) / deviation,
               unshifted / (*peak - mean)};
}

std::optional<Finding> checkRegistration(const EdgeAlignment& alignment, int step_px) {
  const auto shift = alignment.findShift();
  if (!shift || shift->significance < kMinSignificance || shift->unshifted > kMaxUnshifted) {
    return std::nullopt;
  }
  const int largest_px = std::max(std::abs(shift->dx_px), std::abs(shift->dy_px));
  if (largest_px < kMinShift_px) return std::nullopt;
  return Finding{"registration",
                 "in " + std::to_string(alignment.numImages()) +
                     " images, colour edges lie about (" + std::to_string(shift->dx_px * step_px) +
                     ", " + std::to_string(shift->dy_px * step_px) + ") px beside depth edges",
                 "usually depth is not registered to colour, or the two were taken at different"
                 " times",
                 "use the driver's registered depth (aligned_depth_to_color, depth_registered) and"
                 " a smaller input/sync_tolerance_s"};
}

}  // namespace tsg::plausibility
