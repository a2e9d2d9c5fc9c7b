// SPDX-License-Identifier: BSD-3-Clause
// From a map folder to a map.
#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "folder_lock.h"
#include "state_files.h"
#include "task_scene_graph/map/files.h"
#include "task_scene_graph/scene_graph/region_layer.h"

namespace tsg::map {
namespace fs = std::filesystem;
namespace {

constexpr const char* kGraphFile = "scene_graph.json";
constexpr const char* kOccupancyFile = "map.ot";

template <typename Value>
void requireSame(const fs::path& folder, const char* what, const Value& found,
                 const Value& expected, const std::string& hint) {
  if (found == expected || expected == Value{} || found == Value{}) return;
  std::ostringstream message;
  message << "map '" << folder.string() << "' has " << what << " " << found << ", expected "
          << expected << " as " << hint;
  throw std::runtime_error(message.str());
}

std::string quote(const std::string& text) { return text.empty() ? "" : "'" + text + "'"; }

void requireUse(const fs::path& folder, const ManifestHead& head, const MapUse& use) {
  requireSame(folder, "coordinates in frame", quote(head.world_frame), quote(use.world_frame),
              "here (parameter world_frame)");
  requireSame(folder, "embeddings of model set", quote(head.model_set), quote(use.model_set),
              "here (parameter models): vectors of two sets cannot be compared");
  requireSame(folder, "embeddings of size", static_cast<std::int64_t>(head.embedding_size),
              static_cast<std::int64_t>(use.embedding_size), "here (model set and tasks)");
}

void requireVoxels(const fs::path& folder, const Map& map, const MapUse& use) {
  requireSame(folder, "a mesh of voxels of [m]", map.meshVoxelSize(), use.mesh_voxel_size_m,
              "here (mesh_fusion/background/tsdf/voxel_size_m)");
  requireSame(folder, "free space in voxels of [m]", map.placeMemory()->voxel_size_m,
              use.free_space_voxel_size_m, "here (mesh_fusion/free_space/tsdf/voxel_size_m)");
}

/// Reads the parts of a map, those that every map has and those that it may lack.
void readParts(const fs::path& folder, const Manifest& manifest, Map& map) {
  const auto read = [&](const char* name, bool is_needed, auto reader) {
    if (manifest.files.count(name) > 0) return reader(locateFile(folder, name), map);
    if (!is_needed) return;
    throw std::runtime_error("map '" + folder.string() + "' has no " + name +
                             ": it was not saved as a whole");
  };
  read(kTasksFile, true, readTasksState);
  read(kPrimitivesFile, true, readPrimitives);
  read(kPlacesFile, true, readPlaces);
  read(kClustersFile, true, readClusters);
  read(kMeshBlocksFile, false, readMeshBlocks);
  read(kTrajectoryFile, false, readTrajectoryState);
  read(kPlaceMemoryFile, false, readPlaceMemory);
}

/// What only holds of all parts together.
void requireConsistent(const fs::path& folder, const Map& map) {
  try {
    scene_graph::checkPlaceGraph(*map.places());
    computeSceneGraph(map);
  } catch (const std::exception& e) {
    throw std::runtime_error("map '" + folder.string() + "' is damaged: " + e.what());
  }
}

}  // namespace

LoadedMap loadMap(const fs::path& folder, const MapUse& use) {
  const FolderLock lock(folder, FolderLock::Kind::kShared);
  const Manifest manifest = readManifest(folder);
  requireUse(folder, manifest.head, use);
  LoadedMap loaded{Map(manifest.head.world_frame), {}};
  const std::vector<std::string> edited = checkFiles(folder, manifest);
  readParts(folder, manifest, loaded.map);
  requireVoxels(folder, loaded.map, use);
  MapSettings settings = loaded.map.settings();
  settings.model_set = manifest.head.model_set;
  loaded.map.setSettings(std::move(settings));
  loaded.map.setSources(manifest.head.sources);
  requireConsistent(folder, loaded.map);
  const bool is_edited = std::find(edited.begin(), edited.end(), kGraphFile) != edited.end();
  if (is_edited && fs::exists(locateFile(folder, kGraphFile))) {
    loaded.notes = applyEdits(locateFile(folder, kGraphFile), loaded.map);
    requireConsistent(folder, loaded.map);
  }
  return loaded;
}

std::shared_ptr<mapping::OccupancyMap> readOccupancy(const fs::path& folder,
                                                     const mapping::OccupancyConfig& config) {
  if (readManifest(folder).files.count(kOccupancyFile) == 0) return nullptr;
  return std::make_shared<mapping::OccupancyMap>(
      mapping::OccupancyMap::read(locateFile(folder, kOccupancyFile), config));
}

}  // namespace tsg::map
