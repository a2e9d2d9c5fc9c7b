// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace tsg::rviz_plugin {

/// Where rviz's view `Orbit` looks to.
struct OrbitView {
  Eigen::Vector3d focal_point_m = Eigen::Vector3d::Zero();
  double distance_m = 0.0;
};

/// Which part of a line (or plane) a view shows: from the smallest to the largest number.
struct Interval {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void add(double below, double above) {
    low = std::min(low, below);
    high = std::max(high, above);
  }
};

/// The nearest view from a direction in which a whole box is seen.
///
/// The camera is at focal_point - distance * forward. A corner at (x, y) across and z along the
/// view, seen from the box's centre, is within the picture if |x - x_focal| <= (distance + z)
/// tan_x, and the same for y; so distance >= (max(x - z tan_x) - min(x + z tan_x)) / (2 tan_x).
/// @param box        not empty
/// @param yaw_rad, pitch_rad  rviz's: of the camera, seen from the focal point
/// @param tan_up     tangent of half the vertical field of view
/// @param aspect     width / height of the picture
/// @param margin     1: the box touches the edges; 1.1: a tenth is left
inline OrbitView fitOrbitView(const Eigen::AlignedBox3d& box, double yaw_rad, double pitch_rad,
                              double tan_up, double aspect, double margin) {
  const Eigen::Vector3d forward(-std::cos(yaw_rad) * std::cos(pitch_rad),
                                -std::sin(yaw_rad) * std::cos(pitch_rad), -std::sin(pitch_rad));
  const Eigen::Vector3d right(-std::sin(yaw_rad), std::cos(yaw_rad), 0.0);
  const Eigen::Vector3d up = right.cross(forward);
  const double tan_y = tan_up / margin;
  const double tan_x = tan_y * aspect;
  Interval across;
  Interval upward;
  for (int i = 0; i < 8; ++i) {
    const auto corner = static_cast<Eigen::AlignedBox3d::CornerType>(i);
    const Eigen::Vector3d p = box.corner(corner) - box.center();
    const double z = p.dot(forward);
    across.add(p.dot(right) + z * tan_x, p.dot(right) - z * tan_x);
    upward.add(p.dot(up) + z * tan_y, p.dot(up) - z * tan_y);
  }
  OrbitView view;
  view.distance_m = std::max((across.high - across.low) / (2.0 * tan_x),
                             (upward.high - upward.low) / (2.0 * tan_y));
  view.focal_point_m = box.center() + 0.5 * (across.high + across.low) * right +
                       0.5 * (upward.high + upward.low) * up;
  return view;
}

/// Pixels for a metre with which rviz's view `TopDownOrtho` shows a whole box.
inline double fitScale(const Eigen::AlignedBox3d& box, double angle_rad, double width_px,
                       double height_px, double margin) {
  const double c = std::abs(std::cos(angle_rad));
  const double s = std::abs(std::sin(angle_rad));
  const Eigen::Vector3d size_m = box.sizes();
  const double across_m = std::max(c * size_m.x() + s * size_m.y(), 0.1);
  const double upward_m = std::max(s * size_m.x() + c * size_m.y(), 0.1);
  return std::min(width_px / across_m, height_px / upward_m) / margin;
}

}  // namespace tsg::rviz_plugin
