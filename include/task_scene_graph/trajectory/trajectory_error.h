// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/core/trajectory.h"

namespace tsg::trajectory {

/// Root mean square distance [m] of the estimate's positions from the true ones at their stamps,
/// once the estimate is moved rigidly so that its first pose is true: what a map that began right
/// is off by. O(poses log poses).
/// @throws std::invalid_argument naming the stamp if the truth has none within 0.5 s on both sides,
/// or if the estimate is empty.
double computeTrajectoryError(const Trajectory& truth, const Trajectory& estimate);

}  // namespace tsg::trajectory
