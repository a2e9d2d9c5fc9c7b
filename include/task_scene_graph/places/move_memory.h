// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include "task_scene_graph/places/place_memory.h"

namespace tsg::places {

/// How what is at a position moves: p_new = T_new_old * p_old.
using MotionField = std::function<Pose(const Eigen::Vector3d& p_m)>;

/// A memory whose parts have moved: blocks of voxels each rigidly, as their middle does, resampled
/// to the nearest voxel (of two that come to lie in one, that of the block that comes first stays);
/// places, views and the way as where they are. Ids stay. The ground plan is empty: it follows once
/// an extractor has been restored. O(voxels).
PlaceMemory moveMemory(const PlaceMemory& memory, const MotionField& motion);

}  // namespace tsg::places
