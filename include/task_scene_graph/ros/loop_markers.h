// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace tsg::ros_interface {

/// A loop closure between two places of the camera.
struct LoopMarkerLine {
  Eigen::Vector3d from_m;
  Eigen::Vector3d to_m;
  bool is_accepted = false;
  double residual_m = 0.0;  ///< what of it the corrected poses leave
};

/// All loop closures in rviz, in place of those drawn before: namespaces accepted (from green to
/// yellow as the residual grows to kLargeResidual_m) and rejected (red, thinner). O(lines).
visualization_msgs::MarkerArray makeLoopMarkers(const std::vector<LoopMarkerLine>& lines,
                                                const std::string& world_frame);

constexpr double kLargeResidual_m = 0.2;

}  // namespace tsg::ros_interface
