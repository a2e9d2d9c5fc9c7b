// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "task_scene_graph/core/files.h"
#include "task_scene_graph/map/folder.h"
#include "task_scene_graph/map/map.h"
#include "task_scene_graph/planning/storeys.h"

/// The files of a map folder, written alike live and offline, and read back (docs/maps.md).
namespace tsg::map {

/// Writes a map into a folder, which is made if it is not there, all at once (replaceFiles()): the
/// graph's part and the background's.
/// @return what was written
/// @throws std::runtime_error naming the path, the map of before stays then; as
/// computeSceneGraph().
std::vector<WrittenFile> writeMap(const std::filesystem::path& folder, const Map& map);

/// What the manifest of a map says.
ManifestHead describeMap(const Map& map);

/// Writes what primitives, places, tasks and clusters make, each file whole or not at all:
///
/// - `scene_graph.json` and `summary.json`, see scene_graph/files.h,
/// - `thumbnails/O<id>.png`: of each object the view of its primitive that was seen largest,
/// - `settings.yaml` where there are settings of stages, see config::writeSettings(),
/// - below `state/`: tasks, primitives, places, clusters.
///
/// @throws std::runtime_error naming the path; as computeSceneGraph().
std::vector<WrittenFile> writeGraphPart(const std::filesystem::path& folder, const Map& map);

enum class BackgroundFiles {
  kAll,       ///< a map's
  kForOthers  ///< without what only this package goes on from (below `state/`)
};

/// Writes what depth images make; a file is absent where the map does not have what it holds:
///
/// - `mesh.ply`: each vertex has the id of the object whose primitives' surface is nearest, if it
///   is within a voxel; 0 = background, or in no object,
/// - `trajectory.txt`: a line `stamp tx ty tz qx qy qz qw` for each pose,
/// - `floor_<n>.pgm` and `.yaml` of each storey, `map.bt` and `map.ot` of the occupancy map,
/// - below `state/`: blocks of the mesh, trajectory, free space.
///
/// @param object_of_primitive  for the vertices' ids
/// @throws std::runtime_error naming the path; as mapping::labelVertices().
std::vector<WrittenFile> writeBackgroundPart(
    const std::filesystem::path& folder, const Map& map,
    const std::map<PrimitiveId, std::int32_t>& object_of_primitive,
    const std::vector<planning::StoreyGrid>& storeys, BackgroundFiles what = BackgroundFiles::kAll);

/// The storeys of a map's ground plan.
std::vector<planning::StoreyGrid> computeStoreys(const Map& map);

/// Writes `settings.yaml`, as config::writeSettings(). @throws std::runtime_error naming the path.
WrittenFile writeSettingsFile(const std::filesystem::path& folder,
                              const std::vector<config::YamlLine>& record,
                              const std::vector<config::StageSettings>& stages);

/// What a map is to be used with. Empty and 0: anything.
struct MapUse {
  std::string world_frame;
  std::string model_set;
  Eigen::Index embedding_size = 0;
  double mesh_voxel_size_m = 0.0;
  double free_space_voxel_size_m = 0.0;
};

struct LoadedMap {
  Map map;
  std::vector<std::string> notes;  ///< what the user should know, a line each
};

/// Reads a map folder, also one whose saving was interrupted. Primitives that somebody has taken
/// out of `scene_graph.json`, moved, or put in are so in the map (applyEdits()). The occupancy map
/// is left out; readOccupancy() reads it.
/// @throws std::runtime_error naming folder or file, what was found and what was expected: no map,
/// another version, files that are missing or damaged, or a map that does not fit `use`.
LoadedMap loadMap(const std::filesystem::path& folder, const MapUse& use = {});

/// The occupancy map of a map folder; null if it has none.
/// @throws std::runtime_error naming the file; as mapping::OccupancyMap::read().
std::shared_ptr<mapping::OccupancyMap> readOccupancy(const std::filesystem::path& folder,
                                                     const mapping::OccupancyConfig& config);

/// Takes over what was edited in a scene graph, by this package's own program or by spark_dsg:
/// primitives (layer SEGMENTS) that are gone are erased, moved ones are moved with their mesh, new
/// ones are put in without a mesh. All else in the file follows from primitives and places, and
/// does not count. @returns what was taken over, and what was not, a line each
/// @throws std::runtime_error as scene_graph::SceneGraphFile.
std::vector<std::string> applyEdits(const std::filesystem::path& scene_graph_json, Map& map);

}  // namespace tsg::map
