// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "task_scene_graph/core/files.h"
#include "task_scene_graph/map/map.h"
#include "task_scene_graph/mapping/occupancy_map.h"

/// The files of a map folder, written alike live and offline (docs/map_files.md).
namespace tsg::map {

/// Writes a map into a folder, which is made if it is not there; each file whole or not at all:
///
/// - `scene_graph.json` and `summary.json`, see scene_graph/files.h,
/// - `trajectory.txt` where the trajectory has poses: a line `stamp tx ty tz qx qy qz qw` for each,
/// - `mesh.ply` where the map has a mesh: each vertex has the id of the object whose primitives'
///   surface is nearest, if it is within a voxel; 0 = background, or in no object,
/// - `settings.yaml` where there are settings of stages, see config::writeSettings().
///
/// @return what was written, in this order
/// @throws std::runtime_error naming the path; as computeSceneGraph().
std::vector<WrittenFile> writeMap(const std::filesystem::path& folder, const Map& map);

/// Writes `scene_graph.json` and `summary.json`. @throws std::runtime_error naming the path.
std::vector<WrittenFile> writeGraphFiles(const std::filesystem::path& folder,
                                         const scene_graph::SceneGraph& graph);

/// Writes `mesh.ply` with an object id per vertex, as above.
/// @param max_distance_m  of a vertex from the surface of its object's primitives
/// @param world_frame     name of the frame that the mesh is in
/// @throws std::runtime_error naming the path; as mapping::labelVertices().
WrittenFile writeMeshFile(const std::filesystem::path& folder, const Mesh& mesh,
                          const std::vector<ObjectPrimitivePtr>& primitives,
                          const std::map<PrimitiveId, std::int32_t>& object_of_primitive,
                          double max_distance_m, const std::string& world_frame);

/// Writes `map.bt` (free, occupied, unknown) and `map.ot` (probabilities); nothing for null.
/// @throws as mapping::OccupancyMap::write().
std::vector<WrittenFile> writeOccupancyFiles(const std::filesystem::path& folder,
                                             const mapping::OccupancyMap* map);

/// Writes `settings.yaml`, as config::writeSettings(). @throws std::runtime_error naming the path.
WrittenFile writeSettingsFile(const std::filesystem::path& folder,
                              const std::vector<config::YamlLine>& record,
                              const std::vector<config::StageSettings>& stages);

}  // namespace tsg::map
