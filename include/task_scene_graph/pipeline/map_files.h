// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <vector>

#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/mapping/occupancy_map.h"

namespace tsg::pipeline {

/// Writes `mesh.ply` with an object id per vertex: that of the object whose primitives' surface is
/// nearest, if it is within `max_distance_m`; 0 = background, or in no object.
/// @throws std::runtime_error naming the path; as mapping::labelVertices().
void writeMeshFile(const std::filesystem::path& folder, const Mesh& mesh,
                   const std::vector<ObjectPrimitivePtr>& primitives,
                   const std::map<PrimitiveId, std::int32_t>& object_of_primitive,
                   double max_distance_m);

/// Writes `map.bt` (free, occupied, unknown) and `map.ot` (probabilities); nothing for null.
/// @throws as mapping::OccupancyMap::write().
void writeOccupancyFiles(const std::filesystem::path& folder, const mapping::OccupancyMap* map);

}  // namespace tsg::pipeline
