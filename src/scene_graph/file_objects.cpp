// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/file_objects.h"

#include <cstdint>
#include <optional>
#include <stdexcept>

#include "graph_layers.h"
#include "json_fields.h"
#include "node_attributes.h"
#include "node_box.h"
#include "node_mesh.h"
#include "task_scene_graph/scene_graph/scene_graph_file.h"

namespace tsg::scene_graph {
namespace {

using nlohmann::json;

constexpr std::size_t kFewestVertices = 4;  // of a solid

std::optional<RotatedBox> readNotedBox(const json& attributes) {
  const auto metadata = attributes.find("metadata");
  if (metadata == attributes.end() || !metadata->is_object()) return std::nullopt;
  const auto noted = metadata->find("oriented_box");
  if (noted == metadata->end()) return std::nullopt;
  const json& yaw = getField(*noted, "yaw_rad");
  if (!yaw.is_number()) failOn("yaw_rad", yaw, "a number");
  OrientedBox box;
  box.center_m = readVector(*noted, "center_m");
  box.size_m = readVector(*noted, "size_m");
  box.yaw_rad = yaw.get<double>();
  return toRotatedBox(box);
}

RotatedBox fitToMesh(const JsonText& text, const JsonObject& attributes, const json& solid) {
  const NodeMesh mesh = readMesh(text, attributes, readMeshFrame(solid));
  if (mesh.points_m.size() < kFewestVertices) {
    fail("has a mesh of " + std::to_string(mesh.points_m.size()) + " vertices, expected at least " +
         std::to_string(kFewestVertices));
  }
  // Relative to one of them: a float holds no millimetres at a map projection's coordinates.
  const Eigen::Vector3d origin_m = mesh.points_m.front();
  std::vector<Eigen::Vector3f> points_m;
  for (const Eigen::Vector3d& p : mesh.points_m) {
    points_m.emplace_back((p - origin_m).cast<float>());
  }
  OrientedBox box = computeOrientedBox(points_m);
  box.center_m += origin_m;
  return toRotatedBox(box);
}

void checkBox(const RotatedBox& box) {
  const bool is_solid = box.center_m.allFinite() && box.size_m.allFinite() &&
                        box.rotation.allFinite() && (box.size_m.array() >= 0.0).all();
  if (!is_solid) fail("has a box that is not finite");
  if (box.size_m.isZero(0.0)) fail("has a box without size");
}

FileObject readObject(const JsonText& text, const JsonObject& attributes, BoxSource source) {
  const json solid = readFields(text, attributes, {"position", "bounding_box", "name", "metadata"});
  FileObject object;
  const auto name = solid.find("name");
  if (name != solid.end() && name->is_string()) object.name = name->get<std::string>();
  object.embedding = readEmbedding(text, attributes);
  if (source == BoxSource::kMesh) {
    object.box = fitToMesh(text, attributes, solid);
  } else if (const auto noted = readNotedBox(solid)) {
    object.box = *noted;
  } else {
    object.box = readRotatedBox(solid);
  }
  checkBox(object.box);
  return object;
}

/// The attributes of a static node of a layer; nothing for any other node.
std::optional<JsonObject> findAttributes(const JsonText& text, const JsonObject& node, int layer) {
  const JsonSpan* number = node.find("layer");
  const JsonSpan* partition = node.find("partition");
  const bool is_static = node.find("timestamp") == nullptr &&
                         (partition == nullptr || text.readInteger(*partition) == 0);
  if (number == nullptr || !is_static || text.readInteger(*number) != layer) return std::nullopt;
  const JsonSpan* attributes = node.find("attributes");
  return attributes == nullptr ? JsonObject() : text.readObject(*attributes);
}

FileObjects readLayer(const JsonText& text, FileLayer layer, BoxSource source) {
  const JsonObject graph = text.readObject(text.root());
  const JsonSpan* nodes = graph.find("nodes");
  if (nodes == nullptr || !text.isArray(*nodes)) {
    fail("has no list of 'nodes'; expected a spark_dsg scene graph");
  }
  const GraphLayers layers = readLayers(readFields(text, graph, {"layer_names"}));
  const int number = layer == FileLayer::kObjects ? layers.objects : layers.segments;
  FileObjects read;
  for (const JsonSpan node_text : text.readArray(*nodes)) {
    const JsonObject node = text.readObject(node_text);
    const auto attributes = findAttributes(text, node, number);
    if (!attributes) continue;
    const JsonSpan* id = node.find("id");
    const std::uint64_t key = id == nullptr ? 0 : text.readUnsigned(*id).value_or(0);
    try {
      FileObject object = readObject(text, *attributes, source);
      object.id = key;
      read.objects.push_back(std::move(object));
    } catch (const std::runtime_error& e) {
      read.left_out.push_back((key > 0 ? describeNode(key) : "a node without id") + ' ' + e.what());
    }
  }
  return read;
}

}  // namespace

FileObjects loadFileObjects(const std::string& path, FileLayer layer, BoxSource source) {
  try {
    return readLayer(JsonText::read(path), layer, source);
  } catch (const std::runtime_error& e) {
    throw std::runtime_error("scene graph '" + path + "' " + e.what());
  }
}

}  // namespace tsg::scene_graph
