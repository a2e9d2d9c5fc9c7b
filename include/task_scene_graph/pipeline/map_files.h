// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "task_scene_graph/config/settings.h"
#include "task_scene_graph/core/files.h"
#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/mapping/occupancy_map.h"
#include "task_scene_graph/scene_graph/scene_graph.h"

/// The files of a map folder, written alike live and offline. Each function says what it wrote.
namespace tsg::pipeline {

/// Writes `scene_graph.json` and `summary.json`. The folder is made.
/// @throws std::runtime_error naming the path.
std::vector<WrittenFile> writeGraphFiles(const std::filesystem::path& folder,
                                         const scene_graph::SceneGraph& graph);

/// Writes `mesh.ply` with an object id per vertex: that of the object whose primitives' surface is
/// nearest, if it is within `max_distance_m`; 0 = background, or in no object.
/// @param world_frame  name of the frame that the mesh is in
/// @throws std::runtime_error naming the path; as mapping::labelVertices().
WrittenFile writeMeshFile(const std::filesystem::path& folder, const Mesh& mesh,
                          const std::vector<ObjectPrimitivePtr>& primitives,
                          const std::map<PrimitiveId, std::int32_t>& object_of_primitive,
                          double max_distance_m, const std::string& world_frame);

/// Writes `map.bt` (free, occupied, unknown) and `map.ot` (probabilities); nothing for null.
/// @throws as mapping::OccupancyMap::write().
std::vector<WrittenFile> writeOccupancyFiles(const std::filesystem::path& folder,
                                             const mapping::OccupancyMap* map);

/// Writes `settings.yaml`, as config::writeSettings().
/// @throws std::runtime_error naming the path.
WrittenFile writeSettingsFile(const std::filesystem::path& folder,
                              const std::vector<config::YamlLine>& record,
                              const std::vector<config::StageSettings>& stages);

}  // namespace tsg::pipeline
