// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/trajectory/odometry_bias.h"

namespace tsg::trajectory {

Pose correctOdometry(const Pose& T_a_b, const OdometryBias& bias) {
  const Eigen::Vector3d half_rad = 0.5 * T_a_b.translation().norm() * bias.turn_rad_per_m;
  const Eigen::Quaterniond turn(1.0, half_rad.x(), half_rad.y(), half_rad.z());
  Pose corrected = T_a_b;
  corrected.translation() *= 1.0 + bias.scale;
  corrected.linear() = (Eigen::Quaterniond(T_a_b.linear()) * turn).normalized().toRotationMatrix();
  return corrected;
}

Vector6d computeBiasedError(const Pose& T_a_b, const OdometryBias& bias, const Pose& found_T_a_b) {
  Vector6d error = toVector(correctOdometry(T_a_b, bias).inverse() * found_T_a_b);
  error.head<3>() /= 1.0 + bias.scale;
  return error;
}

Eigen::Matrix<double, 6, 4> computeBiasJacobian(const Pose& T_a_b, const PoseGraphConfig& config) {
  Eigen::Matrix<double, 6, 4> jacobian = Eigen::Matrix<double, 6, 4>::Zero();
  jacobian.topLeftCorner<3, 1>() =
      config.odometry_scale * (T_a_b.linear().transpose() * T_a_b.translation());
  jacobian.bottomRightCorner<3, 3>() =
      config.odometry_turn_rad_per_m * T_a_b.translation().norm() * Eigen::Matrix3d::Identity();
  return jacobian;
}

}  // namespace tsg::trajectory
