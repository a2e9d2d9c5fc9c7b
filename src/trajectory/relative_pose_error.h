// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "task_scene_graph/trajectory/odometry_bias.h"
#include "task_scene_graph/trajectory/pose_graph.h"
#include "task_scene_graph/trajectory/se3.h"

namespace tsg::trajectory {

/// toVector() of a motion, times the root of its information.
template <typename T>
void writeWhitened(const Matrix6d& root, const Eigen::Matrix<T, 3, 1>& position,
                   const Eigen::Quaternion<T>& rotation, T* residual) {
  Eigen::Matrix<T, 6, 1> error;
  error.template head<3>() = position;
  error.template tail<3>() = (rotation.w() < T(0.0) ? T(-2.0) : T(2.0)) * rotation.vec();
  Eigen::Map<Eigen::Matrix<T, 6, 1>> whitened(residual);
  whitened = root.cast<T>() * error;
}

/// computeError() of an edge, times a square root of its information, as Ceres's automatic
/// differentiation takes it. Positions in metres, quaternions as x, y, z, w.
class RelativePoseError {
 public:
  /// @param weight  of the edge's chi2
  RelativePoseError(const Pose& T_a_b, const Matrix6d& information, double weight)
      : p_b_a_(T_a_b.inverse().translation()),
        q_b_a_(Eigen::Quaterniond(T_a_b.linear()).conjugate()),
        root_(std::sqrt(weight) * Matrix6d(information.llt().matrixU())) {}

  template <typename T>
  bool operator()(const T* p_a, const T* q_a, const T* p_b, const T* q_b, T* residual) const {
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Vector3> position_a(p_a);
    const Eigen::Map<const Vector3> position_b(p_b);
    const Eigen::Quaternion<T> turn_a = Eigen::Map<const Eigen::Quaternion<T>>(q_a).conjugate();
    const Eigen::Map<const Eigen::Quaternion<T>> turn_b(q_b);
    const Vector3 found = turn_a * Vector3(position_b - position_a);
    const Vector3 position = q_b_a_.cast<T>() * found + p_b_a_.cast<T>();
    const Eigen::Quaternion<T> rotation = q_b_a_.cast<T>() * turn_a * turn_b;
    writeWhitened(root_, position, rotation, residual);
    return true;
  }

 private:
  Eigen::Vector3d p_b_a_;
  Eigen::Quaterniond q_b_a_;
  Matrix6d root_;  ///< U with U^T U = weight * information
};

/// computeBiasedError() likewise, by the bias in units of its deviations: scale, then turn.
class BiasedPoseError {
 public:
  BiasedPoseError(const PoseEdge& edge, const PoseGraphConfig& config, double weight)
      : p_a_b_(edge.T_a_b.translation()),
        q_b_a_(Eigen::Quaterniond(edge.T_a_b.linear()).conjugate()),
        scale_(config.odometry_scale),
        half_turn_rad_(0.5 * config.odometry_turn_rad_per_m * edge.T_a_b.translation().norm()),
        root_(std::sqrt(weight) * Matrix6d(edge.information.llt().matrixU())) {}

  template <typename T>
  bool operator()(const T* p_a, const T* q_a, const T* p_b, const T* q_b, const T* bias,
                  T* residual) const {
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Vector3> position_a(p_a);
    const Eigen::Map<const Vector3> position_b(p_b);
    const Eigen::Quaternion<T> turn_a = Eigen::Map<const Eigen::Quaternion<T>>(q_a).conjugate();
    const Eigen::Map<const Eigen::Quaternion<T>> turn_b(q_b);
    const T half(half_turn_rad_);
    Eigen::Quaternion<T> back(T(1.0), -half * bias[1], -half * bias[2], -half * bias[3]);
    back.normalize();
    const Eigen::Quaternion<T> q_b_a = back * q_b_a_.cast<T>();
    const Vector3 found = turn_a * Vector3(position_b - position_a);
    const Vector3 position =
        q_b_a * Vector3(found / (T(1.0) + T(scale_) * bias[0]) - p_a_b_.cast<T>());
    const Eigen::Quaternion<T> rotation = q_b_a * turn_a * turn_b;
    writeWhitened(root_, position, rotation, residual);
    return true;
  }

 private:
  Eigen::Vector3d p_a_b_;
  Eigen::Quaterniond q_b_a_;
  double scale_;
  double half_turn_rad_;
  Matrix6d root_;
};

/// A bias of one deviation costs 1.
struct BiasPrior {
  template <typename T>
  bool operator()(const T* bias, T* residual) const {
    for (int i = 0; i < 4; ++i) residual[i] = bias[i];
    return true;
  }
};

}  // namespace tsg::trajectory
