// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/oriented_box.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace tsg {
namespace {

// A turned box must be smaller than the aligned one by more than rounding.
constexpr double kLeastGain = 1e-4;

struct Footprint {
  double yaw_rad = 0.0;
  Eigen::AlignedBox2d box;  ///< in axes turned by yaw
  double area() const { return box.sizes().prod(); }
};

Footprint computeFootprint(const std::vector<cv::Point2f>& hull, double yaw_rad) {
  Footprint footprint{yaw_rad, {}};
  const Eigen::Matrix2d R_box_world = Eigen::Rotation2Dd(-yaw_rad).toRotationMatrix();
  for (const auto& p : hull) {
    footprint.box.extend(
        Eigen::Vector2d(R_box_world * Eigen::Vector2d(static_cast<double>(p.x), p.y)));
  }
  return footprint;
}

/// The equivalent direction of a rectangle's side in [-pi/4, pi/4).
double toQuarter(double angle_rad) {
  return angle_rad - M_PI_2 * std::floor(angle_rad / M_PI_2 + 0.5);
}

Footprint findLeastFootprint(const std::vector<cv::Point2f>& points) {
  std::vector<cv::Point2f> hull;
  cv::convexHull(points, hull);
  Footprint best = computeFootprint(hull, 0.0);
  double limit = best.area() * (1.0 - kLeastGain);
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const cv::Point2f side = hull[(i + 1) % hull.size()] - hull[i];
    const Footprint turned = computeFootprint(
        hull, toQuarter(std::atan2(static_cast<double>(side.y), static_cast<double>(side.x))));
    if (turned.area() >= limit) continue;
    best = turned;
    limit = best.area();
  }
  return best;
}

}  // namespace

bool OrientedBox::contains(const Eigen::Vector3d& p_world, double margin_m) const {
  const Eigen::Vector3d p_box = rotation().transpose() * (p_world - center_m);
  return (p_box.array().abs() <= 0.5 * size_m.array() + margin_m).all();
}

std::array<Eigen::Vector3f, 8> OrientedBox::corners() const {
  std::array<Eigen::Vector3f, 8> corners;
  const Eigen::Matrix3d R_world_box = rotation();
  for (std::size_t i = 0; i < 8; ++i) {
    const Eigen::Vector3d sign((i & 1U) != 0 ? 0.5 : -0.5, (i & 2U) != 0 ? 0.5 : -0.5,
                               (i & 4U) != 0 ? 0.5 : -0.5);
    corners[i] = (center_m + R_world_box * sign.cwiseProduct(size_m)).cast<float>();
  }
  return corners;
}

OrientedBox computeOrientedBox(const std::vector<Eigen::Vector3f>& points_m) {
  if (points_m.empty()) return {};
  Aabb bounds;
  for (const auto& p : points_m) bounds.extend(p.cast<double>());
  const Eigen::Vector3d origin = bounds.center();  // single precision is for small numbers
  std::vector<cv::Point2f> plan;
  plan.reserve(points_m.size());
  for (const auto& p : points_m) {
    const Eigen::Vector3f from_origin = (p.cast<double>() - origin).cast<float>();
    plan.emplace_back(from_origin.x(), from_origin.y());
  }
  const Footprint footprint = findLeastFootprint(plan);
  OrientedBox box;
  box.yaw_rad = footprint.yaw_rad;
  const Eigen::Vector2d center = footprint.box.center();
  box.center_m = origin + box.rotation() * Eigen::Vector3d(center.x(), center.y(), 0.0);
  box.size_m << footprint.box.sizes(), bounds.sizes().z();
  return box;
}

OrientedBox toOrientedBox(const Aabb& box) {
  if (box.isEmpty()) return {};
  return {box.center(), box.sizes(), 0.0};
}

}  // namespace tsg
