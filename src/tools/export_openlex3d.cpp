// SPDX-License-Identifier: BSD-3-Clause
// Writes the objects of a scene graph as predictions for the OpenLex3D benchmark.

#include <filesystem>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>

#include "command_line.h"
#include "saved_map.h"
#include "task_scene_graph/evaluation/openlex3d.h"
#include "task_scene_graph/map/files.h"

namespace options = boost::program_options;
namespace fs = std::filesystem;
using namespace tsg;
using scene_graph::FileLayer;

namespace {

struct Arguments {
  std::string map;
  std::string output;
  FileLayer layer = FileLayer::kSegments;
  double cell_m = 0.02;
};

constexpr const char* kUsage =
    "Writes embeddings.npy, index.npy and point_cloud.pcd of a map, as the OpenLex3D benchmark\n"
    "reads predictions. Embeddings must be those of the CLIP model that it is run with.\n"
    "usage: export_openlex3d --map MAP --output FOLDER [options]\noptions";

std::optional<Arguments> parseArguments(int argc, char** argv) {
  Arguments arguments;
  std::string layer = "segments";
  options::options_description description(kUsage);
  description.add_options()("help,h", "print this")(
      "map", tools::pathOption(arguments.map)->required(),
      "map folder, or a scene graph in spark_dsg's JSON with meshes (of any system)")(
      "output", tools::pathOption(arguments.output)->required(), "folder to write")(
      "layer", options::value(&layer),
      "segments: the primitives, which know no tasks; or objects (segments)")(
      "cell", options::value(&arguments.cell_m),
      "one point of an object is kept in each cell of this side, m; 0: all (0.02)");
  if (!tools::parseOptions(argc, argv, description)) return std::nullopt;
  if (layer != "segments" && layer != "objects") {
    throw options::error("--layer is '" + layer + "', expected segments or objects");
  }
  if (!(arguments.cell_m >= 0.0)) {
    throw options::error("--cell is " + std::to_string(arguments.cell_m) + ", expected 0 or more");
  }
  if (layer == "objects") arguments.layer = FileLayer::kObjects;
  return arguments;
}

void addMesh(const ObjectPrimitive& primitive, scene_graph::FileObject& object) {
  const Mesh& mesh = primitive.mesh;
  for (const Eigen::Vector3f& p_m : mesh.vertices) object.points_m.push_back(p_m.cast<double>());
  object.colors.insert(object.colors.end(), mesh.colors.begin(), mesh.colors.end());
  object.colors.resize(object.points_m.size(), {128, 128, 128});
}

std::vector<scene_graph::FileObject> makePrimitives(const map::Map& map) {
  std::vector<scene_graph::FileObject> objects;
  for (const auto& primitive : map.primitives()) {
    objects.emplace_back();
    objects.back().embedding = primitive->embedding;
    addMesh(*primitive, objects.back());
  }
  return objects;
}

std::vector<scene_graph::FileObject> makeObjects(const map::Map& map) {
  std::vector<scene_graph::FileObject> objects;
  for (const scene_graph::SceneObject& object : map::computeSceneGraph(map).objects) {
    objects.emplace_back();
    objects.back().embedding = object.embedding;
    for (const PrimitiveId id : object.primitives) {
      if (const auto primitive = map.findPrimitive(id)) addMesh(*primitive, objects.back());
    }
  }
  return objects;
}

/// A map folder keeps its meshes beside the scene graph.
std::vector<scene_graph::FileObject> readFolder(const Arguments& arguments) {
  const map::Map map = tools::loadMap(arguments.map);
  return arguments.layer == FileLayer::kObjects ? makeObjects(map) : makePrimitives(map);
}

std::vector<scene_graph::FileObject> readGraph(const Arguments& arguments) {
  const auto read =
      scene_graph::loadFileObjects(arguments.map, arguments.layer, scene_graph::BoxSource::kFile,
                                   scene_graph::MeshPoints::kRead);
  for (const std::string& node : read.left_out) {
    std::cerr << "export_openlex3d: left out: " << node << '\n';
  }
  return read.objects;
}

void run(const Arguments& arguments) {
  const auto objects =
      fs::is_directory(arguments.map) ? readFolder(arguments) : readGraph(arguments);
  try {
    const auto written = evaluation::writeOpenLex3d(arguments.output, objects, arguments.cell_m);
    std::cout << describeWritten(arguments.output, written) << '\n';
  } catch (const std::invalid_argument& e) {
    throw std::runtime_error("map '" + arguments.map + "': " + e.what());
  }
}

}  // namespace

int main(int argc, char** argv) {
  return tools::runProgram("export_openlex3d", argc, argv, parseArguments, run);
}
