// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "task_scene_graph/scene_graph/scene_graph.h"

namespace tsg::scene_graph {

struct SparkDsgOptions {
  bool primitives = true;  ///< write the SEGMENTS layer: every object primitive
  bool meshes = false;  ///< write meshes of primitives and objects, about 100 bytes a vertex each
  bool embeddings = true;  ///< write semantic features
};

/// Writes the graph in the JSON layout of the `spark_dsg` library: layers SEGMENTS (primitives,
/// ids s<n>), OBJECTS (O<n>), PLACES (p<n>) and ROOMS (regions, l<n>). Positions and boxes in the
/// world frame, metres; stamps in nanoseconds. Whole or not at all (core/files.h).
/// @throws std::runtime_error naming the path.
void writeSparkDsg(const std::string& path, const SceneGraph& graph,
                   const SparkDsgOptions& options = {});

/// Writes a small, plain JSON for people and scripts: rooms (regions) -> objects with position,
/// box, task, score, ids; objects of no region under a room whose id is null; counts per task.
/// World frame, metres, seconds. Whole or not at all (core/files.h).
/// @throws std::runtime_error naming the path.
void writeSummary(const std::string& path, const SceneGraph& graph);

}  // namespace tsg::scene_graph
