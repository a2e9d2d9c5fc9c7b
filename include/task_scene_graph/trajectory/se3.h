// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "task_scene_graph/core/frame.h"

namespace tsg::trajectory {

/// Translation [m] in rows 0 to 2, rotation [rad] in rows 3 to 5.
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Whether the pose is finite and its linear part a rotation, within 1e-6.
bool isRigid(const Pose& pose);

/// Whether the pose is the identity to the bit.
bool isIdentity(const Pose& pose);

/// By how much a motion turns [rad], 0 to pi.
double computeAngle(const Pose& motion);

/// A motion as a unit dual quaternion turn + epsilon * shift, coefficients in the order x, y, z, w.
/// Linear: sums with weights are blends once they are divided by the length of `turn`, as long as
/// all `turn` lie on one side of the double cover [DualQuat08].
struct DualQuaternion {
  Eigen::Vector4d turn = Eigen::Vector4d::UnitW();
  Eigen::Vector4d shift = Eigen::Vector4d::Zero();
};

/// @param pivot  the result is on its side of the double cover
DualQuaternion toDualQuaternion(const Pose& motion, const Eigen::Vector4d& pivot);

/// A small motion as a vector: its translation, and twice the vector part of its unit quaternion
/// with w >= 0, which is axis times 2 sin(angle / 2): the angle itself for small ones, and smooth
/// up to half a turn.
Vector6d toVector(const Pose& motion);

/// Ad(T): T * E = E' * T holds to first order for small motions E, E' with toVector(E') = Ad(T) *
/// toVector(E).
Matrix6d computeAdjoint(const Pose& T);

}  // namespace tsg::trajectory
