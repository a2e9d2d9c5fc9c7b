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

/// A small motion as a vector: its translation, and twice the vector part of its unit quaternion
/// with w >= 0, which is axis times 2 sin(angle / 2): the angle itself for small ones, and smooth
/// up to half a turn.
Vector6d toVector(const Pose& motion);

/// Ad(T): T * E = E' * T holds to first order for small motions E, E' with toVector(E') = Ad(T) *
/// toVector(E).
Matrix6d computeAdjoint(const Pose& T);

}  // namespace tsg::trajectory
