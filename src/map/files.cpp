// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/map/files.h"

#include "task_scene_graph/core/trajectory.h"
#include "task_scene_graph/mapping/ply.h"
#include "task_scene_graph/mapping/vertex_labels.h"
#include "task_scene_graph/scene_graph/files.h"

namespace tsg::map {
namespace {

namespace fs = std::filesystem;

WrittenFile writeTrajectory(const fs::path& folder, const Map& map) {
  writeTumTrajectory((folder / "trajectory.txt").string(), *map.trajectory(),
                     "T_" + map.worldFrame() + "_camera");
  return {"trajectory.txt", formatCount(map.trajectory()->size(), "pose")};
}

}  // namespace

std::vector<WrittenFile> writeMap(const fs::path& folder, const Map& map) {
  const scene_graph::SceneGraph graph = computeSceneGraph(map);
  const MapSettings& settings = map.settings();
  std::vector<WrittenFile> files = writeGraphFiles(folder, graph);
  if (!map.trajectory()->isEmpty()) files.push_back(writeTrajectory(folder, map));
  if (map.meshVoxelSize() > 0.0) {
    files.push_back(writeMeshFile(folder, computeMesh(map), map.primitives(),
                                  computeObjectOfPrimitives(graph), map.meshVoxelSize(),
                                  map.worldFrame()));
  }
  if (!settings.stages.empty()) {
    files.push_back(writeSettingsFile(folder, settings.record, settings.stages));
  }
  return files;
}

std::vector<WrittenFile> writeGraphFiles(const fs::path& folder,
                                         const scene_graph::SceneGraph& graph) {
  scene_graph::writeSparkDsg((folder / "scene_graph.json").string(), graph);
  scene_graph::writeSummary((folder / "summary.json").string(), graph);
  const std::string content = formatCount(graph.objects.size(), "object") + ", " +
                              formatCount(graph.regions.size(), "region") + ", " +
                              formatCount(graph.places->places.size(), "place");
  return {{"scene_graph.json", content}, {"summary.json", ""}};
}

WrittenFile writeMeshFile(const fs::path& folder, const Mesh& mesh,
                          const std::vector<ObjectPrimitivePtr>& primitives,
                          const std::map<PrimitiveId, std::int32_t>& object_of_primitive,
                          double max_distance_m, const std::string& world_frame) {
  mapping::writePly(folder / "mesh.ply", mesh,
                    mapping::labelVertices(mesh, primitives, object_of_primitive, max_distance_m),
                    world_frame);
  const bool is_one = mesh.vertices.size() == 1;
  return {"mesh.ply", std::to_string(mesh.vertices.size()) + (is_one ? " vertex" : " vertices")};
}

std::vector<WrittenFile> writeOccupancyFiles(const fs::path& folder,
                                             const mapping::OccupancyMap* map) {
  if (map == nullptr) return {};
  map->write(folder / "map.bt");
  map->write(folder / "map.ot");
  return {{"map.bt", ""}, {"map.ot", ""}};
}

WrittenFile writeSettingsFile(const fs::path& folder, const std::vector<config::YamlLine>& record,
                              const std::vector<config::StageSettings>& stages) {
  writeFileAtomically(folder / "settings.yaml",
                      [&](std::ostream& stream) { config::writeSettings(stream, record, stages); });
  return {"settings.yaml", ""};
}

}  // namespace tsg::map
