// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "task_scene_graph/core/box.h"

namespace tsg {

/// An upright box in the world frame, turned about the vertical (z) only. Sizes of 0: empty.
struct OrientedBox {
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  ///< full sides along the box's own axes
  double yaw_rad = 0.0;  ///< from the world's x axis to the box's, in [-pi/4, pi/4)

  bool isEmpty() const { return size_m.isZero(0.0); }
  Eigen::Matrix3d rotation() const {
    return Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  }
  double volume() const { return size_m.prod(); }
  bool contains(const Eigen::Vector3d& p_world, double margin_m) const;
  std::array<Eigen::Vector3f, 8> corners() const;
};

/// The upright box of least footprint that holds all points: it shares a side with their convex
/// hull seen from above. Of boxes alike, the one nearest to the world's axes. Empty without points.
/// O(n log n).
OrientedBox computeOrientedBox(const std::vector<Eigen::Vector3f>& points_m);

/// The axis-aligned box as an oriented one.
OrientedBox toOrientedBox(const Aabb& box);

}  // namespace tsg
