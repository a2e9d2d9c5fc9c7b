// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/map/files.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "state_files.h"
#include "task_scene_graph/core/trajectory.h"
#include "task_scene_graph/mapping/ply.h"
#include "task_scene_graph/mapping/vertex_labels.h"
#include "task_scene_graph/scene_graph/files.h"

namespace tsg::map {
namespace {

namespace fs = std::filesystem;

const std::string kStateName = "state";  // as a line for people

WrittenFile writeTrajectory(const fs::path& folder, const Map& map) {
  writeTumTrajectory((folder / "trajectory.txt").string(), *map.trajectory(),
                     "T_" + map.worldFrame() + "_camera");
  return {"trajectory.txt", formatCount(map.trajectory()->size(), "pose")};
}

WrittenFile writeMesh(const fs::path& folder, const Map& map,
                      const std::map<PrimitiveId, std::int32_t>& object_of_primitive) {
  const Mesh mesh = computeMesh(map);
  mapping::writePly(
      folder / "mesh.ply", mesh,
      mapping::labelVertices(mesh, map.primitives(), object_of_primitive, map.meshVoxelSize()),
      map.worldFrame());
  const bool is_one = mesh.vertices.size() == 1;
  return {"mesh.ply", std::to_string(mesh.vertices.size()) + (is_one ? " vertex" : " vertices")};
}

void writePng(const fs::path& path, const ColorImage& image) {
  cv::Mat bgr;
  if (image.order == ColorOrder::kRgb) {
    cv::cvtColor(image.image, bgr, cv::COLOR_RGB2BGR);
  } else {
    bgr = image.image;
  }
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", bgr, bytes);
  writeFileAtomically(path, [&](std::ostream& out) {
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
  });
}

/// The primitive of an object that was seen largest; null if none has a picture.
ObjectPrimitivePtr findLargest(const Map& map, const scene_graph::SceneObject& object) {
  ObjectPrimitivePtr largest;
  for (const PrimitiveId id : object.primitives) {
    const ObjectPrimitivePtr primitive = map.findPrimitive(id);
    if (primitive->thumbnail.image.empty()) continue;
    const bool is_larger =
        largest == nullptr || primitive->views.best_pixels > largest->views.best_pixels;
    if (is_larger) largest = primitive;
  }
  return largest;
}

void writeThumbnails(const fs::path& folder, const Map& map, const scene_graph::SceneGraph& graph,
                     std::vector<WrittenFile>& files) {
  std::size_t count = 0;
  for (const auto& object : graph.objects) {
    const ObjectPrimitivePtr largest = findLargest(map, object);
    if (largest == nullptr) continue;
    writePng(folder / "thumbnails" / ("O" + std::to_string(object.id.value) + ".png"),
             largest->thumbnail);
    ++count;
  }
  if (count > 0) files.push_back({"thumbnails", formatCount(count, "image")});
}

void append(std::vector<WrittenFile>& files, std::vector<WrittenFile> more) {
  for (auto& file : more) files.push_back(std::move(file));
}

}  // namespace

std::vector<WrittenFile> writeMap(const fs::path& folder, const Map& map) {
  std::vector<WrittenFile> files;
  replaceFiles(folder, describeMap(map), [&](const fs::path& to) {
    files = writeGraphPart(to, map);
    append(files, writeBackgroundPart(
                      to, map, scene_graph::computeObjectOfPrimitives(computeSceneGraph(map)),
                      computeStoreys(map)));
    return OtherFiles::kRemove;
  });
  files.push_back({kStateName, "to go on from"});
  files.push_back({kManifestName, ""});
  return files;
}

ManifestHead describeMap(const Map& map) {
  return {map.worldFrame(), map.settings().model_set, map.embeddingSize(), map.stamp().ns,
          map.sources()};
}

std::vector<WrittenFile> writeGraphPart(const fs::path& folder, const Map& map) {
  const scene_graph::SceneGraph graph = computeSceneGraph(map);
  scene_graph::writeSparkDsg((folder / "scene_graph.json").string(), graph);
  scene_graph::writeSummary((folder / "summary.json").string(), graph);
  std::vector<WrittenFile> files = {
      {"scene_graph.json", formatCount(graph.objects.size(), "object") + ", " +
                               formatCount(graph.regions.size(), "region") + ", " +
                               formatCount(graph.places->places.size(), "place")},
      {"summary.json", ""}};
  writeThumbnails(folder, map, graph, files);
  const MapSettings& settings = map.settings();
  if (!settings.stages.empty()) {
    files.push_back(writeSettingsFile(folder, settings.record, settings.stages));
  }
  writeTasksState(folder, map);
  writePrimitives(folder, map);
  writePlaces(folder, map);
  writeClusters(folder, map);
  return files;
}

std::vector<WrittenFile> writeBackgroundPart(
    const fs::path& folder, const Map& map,
    const std::map<PrimitiveId, std::int32_t>& object_of_primitive,
    const std::vector<planning::StoreyGrid>& storeys, BackgroundFiles what) {
  std::vector<WrittenFile> files;
  if (!map.trajectory()->isEmpty()) files.push_back(writeTrajectory(folder, map));
  if (map.meshVoxelSize() > 0.0) files.push_back(writeMesh(folder, map, object_of_primitive));
  if (map.occupancy() != nullptr) {
    for (const char* name : {"map.bt", "map.ot"}) {
      map.occupancy()->write(folder / name);
      files.push_back({name, ""});
    }
  }
  append(files, planning::writeStoreyFiles(folder, storeys));
  if (what == BackgroundFiles::kForOthers) return files;
  if (!map.trajectory()->isEmpty()) writeTrajectoryState(folder, map);
  if (map.meshVoxelSize() > 0.0) writeMeshBlocks(folder, map);
  if (!map.placeMemory()->isEmpty()) writePlaceMemory(folder, map);
  return files;
}

std::vector<planning::StoreyGrid> computeStoreys(const Map& map) {
  planning::StoreyMap storeys;
  storeys.update(map.placeMemory()->plan);
  return storeys.storeys();
}

WrittenFile writeSettingsFile(const fs::path& folder, const std::vector<config::YamlLine>& record,
                              const std::vector<config::StageSettings>& stages) {
  writeFileAtomically(folder / "settings.yaml",
                      [&](std::ostream& stream) { config::writeSettings(stream, record, stages); });
  return {"settings.yaml", ""};
}

}  // namespace tsg::map
