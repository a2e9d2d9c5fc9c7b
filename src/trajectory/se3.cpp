// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/trajectory/se3.h"

namespace tsg::trajectory {
namespace {

constexpr double kRotationTolerance = 1e-6;

Eigen::Matrix3d computeCrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d cross;
  cross << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return cross;
}

}  // namespace

bool isRigid(const Pose& pose) {
  if (!pose.matrix().allFinite()) return false;
  const Eigen::Matrix3d R = pose.linear();
  return (R * R.transpose()).isIdentity(kRotationTolerance) && R.determinant() > 0.0;
}

bool isIdentity(const Pose& pose) { return pose.matrix() == Pose::Identity().matrix(); }

double computeAngle(const Pose& motion) {
  return Eigen::AngleAxisd(Eigen::Quaterniond(motion.linear())).angle();
}

DualQuaternion toDualQuaternion(const Pose& motion, const Eigen::Vector4d& pivot) {
  Eigen::Quaterniond q(motion.linear());
  if (q.coeffs().dot(pivot) < 0.0) q.coeffs() = -q.coeffs();
  const Eigen::Vector3d t = motion.translation();
  return {q.coeffs(), 0.5 * (Eigen::Quaterniond(0.0, t.x(), t.y(), t.z()) * q).coeffs()};
}

Vector6d toVector(const Pose& motion) {
  const Eigen::Quaterniond q(motion.linear());
  Vector6d vector;
  vector << motion.translation(), (q.w() < 0.0 ? -2.0 : 2.0) * q.vec();
  return vector;
}

Matrix6d computeAdjoint(const Pose& T) {
  Matrix6d adjoint = Matrix6d::Zero();
  adjoint.topLeftCorner<3, 3>() = T.linear();
  adjoint.bottomRightCorner<3, 3>() = T.linear();
  adjoint.topRightCorner<3, 3>() = computeCrossMatrix(T.translation()) * T.linear();
  return adjoint;
}

}  // namespace tsg::trajectory
