// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/trajectory/pose_graph_config.h"
#include "task_scene_graph/trajectory/se3.h"

namespace tsg::trajectory {

/// What odometry does wrong all the time: its ways are too short or long, and it turns a little
/// with each metre. One for all of a trajectory; so it shows where loops are closed.
struct OdometryBias {
  double scale = 0.0;  ///< the true way is 1 + scale times the measured one
  /// The true motion turns by so much more, in the axes of the keyframe (a camera's: y is down).
  Eigen::Vector3d turn_rad_per_m = Eigen::Vector3d::Zero();
};

/// The motion that was measured, without the bias.
Pose correctOdometry(const Pose& T_a_b, const OdometryBias& bias);

/// toVector() of what is between the motion found and the corrected one; its position in metres as
/// odometry measured them. That matters: noise is a measurement's, and in true metres a smaller
/// scale would make all of it less, so that noise alone would shrink the scale.
Vector6d computeBiasedError(const Pose& T_a_b, const OdometryBias& bias, const Pose& found_T_a_b);

/// Derivative of correctOdometry() as a motion of b's frame, for each of scale and turn in units of
/// their deviations in `config`: 6 x 4. Zero where both are 0.
Eigen::Matrix<double, 6, 4> computeBiasJacobian(const Pose& T_a_b, const PoseGraphConfig& config);

/// Whether the configuration lets odometry have a bias.
inline bool hasBias(const PoseGraphConfig& config) {
  return config.odometry_scale > 0.0 || config.odometry_turn_rad_per_m > 0.0;
}

}  // namespace tsg::trajectory
