// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "task_scene_graph/evaluation/object_scores.h"

namespace tsg::evaluation {

/// Which instances of a rendered house count.
enum class TruthExtent {
  kSeen,  ///< those that the recording shows
  kAll
};

/// Reads which things each task is about, world frame, metres, in the file's order:
///
/// - a YAML file as Clio's datasets have it, and a folder of simulate_apartment (its `tasks.yaml`):
///   task -> [{center: [x, y, z], extents: [full sides], rotation: {w, x, y, z} or [w, x, y, z]}],
/// - the folder of a rendered house: `tasks.json` [{name, instances, seen}] and `instances.json`
///   [{id, aabb_min, aabb_max}]. Only such a folder knows what was seen; `extent` is for it.
///
/// @throws std::runtime_error naming the file, the task, its value and what was expected.
std::vector<TaskTruth> loadObjectTruth(const std::string& path, TruthExtent extent);

}  // namespace tsg::evaluation
