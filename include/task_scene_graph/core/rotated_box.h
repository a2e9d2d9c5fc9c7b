// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "task_scene_graph/core/oriented_box.h"

namespace tsg {

/// A box in any attitude, as ground truth and other systems' maps have them.
struct RotatedBox {
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();      ///< world frame
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();        ///< full sides along the box's own axes
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< from the box's axes to the world's

  double volume() const { return size_m.prod(); }
  /// Points on a face are inside.
  bool contains(const Eigen::Vector3d& p_world) const;
};

RotatedBox toRotatedBox(const OrientedBox& box);

/// Volume of what both boxes have, exact but for rounding: one box's faces cut at the other's
/// planes. 0 where they touch. O(1).
double computeIntersectionVolume(const RotatedBox& a, const RotatedBox& b);

/// Volume of the intersection over that of the union, in [0, 1]; 0 for boxes without volume.
double computeIou(const RotatedBox& a, const RotatedBox& b);

}  // namespace tsg
