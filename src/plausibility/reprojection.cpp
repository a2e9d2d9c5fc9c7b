// SPDX-License-Identifier: BSD-3-Clause
#include "reprojection.h"

#include <algorithm>
#include <cmath>

namespace tsg::plausibility {
namespace {

constexpr float kFullCost = 0.045F;  // relative difference of depth that counts as disagreement
constexpr double kLeftCost = 0.5;    // of points that leave the image: some do in any reading

/// A grid's camera in single precision, with a factor on its focal length.
struct Lens {
  float fx, fy, cx, cy;
  bool is_ray_distance;

  Lens(const CameraModel& camera, const Hypothesis& hypothesis)
      : fx(static_cast<float>(camera.fx_px * hypothesis.focal_factor)),
        fy(static_cast<float>(camera.fy_px * hypothesis.focal_factor)),
        cx(static_cast<float>(camera.cx_px)),
        cy(static_cast<float>(camera.cy_px)),
        is_ray_distance(hypothesis.kind == Hypothesis::Kind::kRayDistance) {}

  Eigen::Vector3f unproject(float u, float v, float reading_m) const {
    const Eigen::Vector3f ray((u - cx) / fx, (v - cy) / fy, 1.0F);
    return is_ray_distance ? Eigen::Vector3f(ray * (reading_m / ray.norm()))
                           : Eigen::Vector3f(ray * reading_m);
  }
  /// The reading that a point in the camera frame would give.
  float measure(const Eigen::Vector3f& p) const { return is_ray_distance ? p.norm() : p.z(); }
};

struct Interval {
  float low = 0.0F;
  float high = 0.0F;
  bool is_valid = false;
};

Interval findReadings(const DepthGrid& grid, int u, int v) {
  const float* row = &grid.z_m[static_cast<std::size_t>(v * grid.camera.width_px + u)];
  const float* next = row + grid.camera.width_px;
  const float low = std::min(std::min(row[0], row[1]), std::min(next[0], next[1]));
  const float high = std::max(std::max(row[0], row[1]), std::max(next[0], next[1]));
  return {low, high, low > 0.0F};
}

float computePointCost(float reading_m, const Interval& seen) {
  const float apart_m = std::max(0.0F, std::max(seen.low - reading_m, reading_m - seen.high));
  const float relative = apart_m / (reading_m * kFullCost);
  return std::min(1.0F, relative * relative);
}

}  // namespace

Disagreement computeDisagreement(const Hypothesis& hypothesis,
                                 const std::vector<PixelDepth>& source, const DepthGrid& target,
                                 const Pose& T_target_source) {
  const Lens lens(target.camera, hypothesis);
  const Eigen::Matrix3f R = T_target_source.linear().cast<float>();
  // All in the units of the readings as given.
  const Eigen::Vector3f t = (T_target_source.translation() / hypothesis.depth_factor).cast<float>();
  const auto right = static_cast<float>(target.camera.width_px - 1);
  const auto bottom = static_cast<float>(target.camera.height_px - 1);
  double in_view_sum = 0.0;
  std::size_t in_view = 0;
  std::size_t left = 0;
  for (const PixelDepth& pixel : source) {
    const Eigen::Vector3f p = R * lens.unproject(pixel.u_px, pixel.v_px, pixel.z_m) + t;
    const float u = lens.fx * p.x() / p.z() + lens.cx;
    const float v = lens.fy * p.y() / p.z() + lens.cy;
    if (!(p.z() > 0.0F && u >= 0.0F && v >= 0.0F && u < right && v < bottom)) {
      ++left;
      continue;
    }
    const Interval seen = findReadings(target, static_cast<int>(u), static_cast<int>(v));
    if (!seen.is_valid) continue;
    in_view_sum += static_cast<double>(computePointCost(lens.measure(p), seen));
    ++in_view;
  }
  Disagreement result;
  result.num_points = in_view + left;
  if (result.num_points == 0) return result;
  const auto total = static_cast<double>(result.num_points);
  result.cost = (in_view_sum + kLeftCost * static_cast<double>(left)) / total;
  result.in_view_share = static_cast<double>(in_view) / total;
  if (in_view > 0) result.in_view_cost = in_view_sum / static_cast<double>(in_view);
  return result;
}

double computeUnchangedShare(const std::vector<PixelDepth>& source, const DepthGrid& target) {
  if (source.empty()) return 0.0;
  const auto unchanged = std::count_if(source.begin(), source.end(), [&](const PixelDepth& pixel) {
    return target.at(static_cast<int>(pixel.u_px), static_cast<int>(pixel.v_px)) == pixel.z_m;
  });
  return static_cast<double>(unchanged) / static_cast<double>(source.size());
}

}  // namespace tsg::plausibility
