// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/depth_filter.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/core/vectorize.h"

namespace tsg::mapping {
namespace {

/// A row of a padded image and its neighbours; entry i is pixel i, entries -1 and count exist.
struct Rows {
  const float* above;
  const float* here;
  const float* below;
};

struct Rejection {
  float step_per_depth;  ///< a step is a difference of more than this times the depth
  std::int32_t min_support;
  std::int32_t rejects_flying;  ///< 1 or 0
};

// A step of half the depth is one whatever the slope; it also makes 0 (invalid) no support.
float computeStepPerDepth(double max_slope, const CameraModel& camera) {
  return static_cast<float>(std::min(0.5, max_slope / std::min(camera.fx_px, camera.fy_px)));
}

inline std::int32_t supports(float neighbor, float z, float step) {
  return std::abs(neighbor - z) <= step ? 1 : 0;
}

/// 1 if z lies between a and b, a step away from each; both must be valid.
inline std::int32_t isBetween(float a, float b, float z, float step) {
  const float low = a < b ? a : b;
  const float high = a < b ? b : a;
  const std::int32_t is_valid = low > 0.0F ? 1 : 0;
  const std::int32_t is_behind_low = z - low > step ? 1 : 0;
  const std::int32_t is_before_high = high - z > step ? 1 : 0;
  return is_valid & is_behind_low & is_before_high;
}

}  // namespace

TSG_VECTORIZE void rejectInRow(const Rows& rows, const Rejection& rule, int count,
                               float* __restrict kept_m) {
  const Rejection local = rule;
  const float* __restrict above = rows.above;
  const float* __restrict here = rows.here;
  const float* __restrict below = rows.below;
  for (int i = 0; i < count; ++i) {
    const float z = here[i];
    const float step = local.step_per_depth * z;
    const std::int32_t support = supports(above[i - 1], z, step) + supports(above[i], z, step) +
                                 supports(above[i + 1], z, step) + supports(here[i - 1], z, step) +
                                 supports(here[i + 1], z, step) + supports(below[i - 1], z, step) +
                                 supports(below[i], z, step) + supports(below[i + 1], z, step);
    const std::int32_t flying =
        isBetween(here[i - 1], here[i + 1], z, step) | isBetween(above[i], below[i], z, step);
    const std::int32_t is_alone = support < local.min_support ? 1 : 0;
    kept_m[i] = (is_alone | (flying & local.rejects_flying)) == 0 ? z : 0.0F;
  }
}

TSG_VECTORIZE void convertRow16(const std::uint16_t* raw, float metres_per_unit, int count,
                                float* __restrict depth_m) {
  for (int i = 0; i < count; ++i) {
    depth_m[i] = raw[i] == 65535 ? 0.0F : static_cast<float>(raw[i]) * metres_per_unit;
  }
}

DepthFilter::DepthFilter(const DepthFilterConfig& config) : config_(config) {
  config::validate(config, "depth filter");
}

DepthImage DepthFilter::apply(const DepthImage& depth, const CameraModel& camera) {
  if (config_.isOff() || depth.image.empty()) return depth;
  readPadded(depth);
  const auto valid = static_cast<std::size_t>(cv::countNonZero(padded_m_));
  cv::Mat kept_m = reject(camera);
  if (config_.edge_margin_px > 0) rejectMargins(camera, kept_m);
  counters_.valid_readings += valid;
  counters_.rejected_readings += valid - static_cast<std::size_t>(cv::countNonZero(kept_m));
  return {config_.bilateral_radius_px > 0 ? smooth(kept_m) : kept_m, 1.0, nullptr};
}

void DepthFilter::readPadded(const DepthImage& depth) {
  const int width = depth.image.cols;
  const int height = depth.image.rows;
  if (padded_m_.cols != width + 2 || padded_m_.rows != height + 2) {
    padded_m_ = cv::Mat::zeros(height + 2, width + 2, CV_32FC1);
  }
  for (int v = 0; v < height; ++v) {
    float* row = padded_m_.ptr<float>(v + 1) + 1;
    if (depth.image.depth() == CV_16U) {
      convertRow16(depth.image.ptr<std::uint16_t>(v), static_cast<float>(depth.metres_per_unit),
                   width, row);
    } else {
      for (int u = 0; u < width; ++u) row[u] = depth.at(u, v);
    }
  }
}

cv::Mat DepthFilter::reject(const CameraModel& camera) {
  const Rejection rule{computeStepPerDepth(config_.max_slope, camera), config_.min_support_px,
                       config_.reject_flying_pixels ? 1 : 0};
  cv::Mat kept_m(padded_m_.rows - 2, padded_m_.cols - 2, CV_32FC1);
  for (int v = 0; v < kept_m.rows; ++v) {
    const Rows rows{padded_m_.ptr<float>(v) + 1, padded_m_.ptr<float>(v + 1) + 1,
                    padded_m_.ptr<float>(v + 2) + 1};
    rejectInRow(rows, rule, kept_m.cols, kept_m.ptr<float>(v));
  }
  return kept_m;
}

void DepthFilter::rejectMargins(const CameraModel& camera, cv::Mat& depth_m) const {
  const float step_per_depth = computeStepPerDepth(config_.max_slope, camera);
  const auto isStep = [&](float z, float neighbor) {
    return z > 0.0F && neighbor > 0.0F && std::abs(neighbor - z) > step_per_depth * z;
  };
  cv::Mat at_step(depth_m.size(), CV_8UC1);
  for (int v = 0; v < depth_m.rows; ++v) {
    const float* above = padded_m_.ptr<float>(v) + 1;
    const float* here = padded_m_.ptr<float>(v + 1) + 1;
    const float* below = padded_m_.ptr<float>(v + 2) + 1;
    auto* mark = at_step.ptr<std::uint8_t>(v);
    for (int u = 0; u < depth_m.cols; ++u) {
      const float z = here[u];
      mark[u] = isStep(z, here[u - 1]) || isStep(z, here[u + 1]) || isStep(z, above[u]) ||
                isStep(z, below[u]);
    }
  }
  const int side_px = 2 * config_.edge_margin_px - 1;  // the marked pixel itself is the first
  cv::dilate(at_step, at_step, cv::Mat::ones(side_px, side_px, CV_8UC1));
  depth_m.setTo(0.0F, at_step);
}

cv::Mat DepthFilter::smooth(const cv::Mat& depth_m) const {
  // Invalid pixels are metres away from valid ones: at this sigma they take no part.
  cv::Mat smooth_m;
  cv::bilateralFilter(depth_m, smooth_m, 2 * config_.bilateral_radius_px + 1,
                      config_.bilateral_sigma_m, 0.5 * config_.bilateral_radius_px + 0.5);
  smooth_m.setTo(0.0F, depth_m == 0.0F);
  return smooth_m;
}

}  // namespace tsg::mapping
