// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/file_objects.h"

#include <algorithm>
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

/// RGB of `count` vertices from what the file lists for them: {r, g, b, a} each, or numbers in a
/// row. Grey unless there is one for each.
std::vector<std::array<std::uint8_t, 3>> readColors(const NodeMesh& mesh) {
  constexpr std::uint8_t kGrey = 128;
  const std::vector<std::array<std::uint8_t, 3>> grey(mesh.points_m.size(), {kGrey, kGrey, kGrey});
  const auto found = mesh.vertex_data.find("colors");
  if (found == mesh.vertex_data.end()) return grey;
  const json list = json::parse("[" + found->second + "]", nullptr, false);
  const std::size_t count = grey.size();
  if (!list.is_array() || count == 0 || list.size() % count != 0) return grey;
  const std::size_t numbers = list.size() / count;  // of each vertex in the flat form
  auto colors = grey;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      const json& first = list[i * numbers];
      const json value = first.is_object() ? first.value(std::string(1, "rgb"[c]), json())
                         : numbers >= 3    ? list[i * numbers + c]
                                           : json();
      if (!value.is_number()) return grey;
      colors[i][c] = static_cast<std::uint8_t>(std::min(255.0, std::max(0.0, value.get<double>())));
    }
  }
  return colors;
}

void readPoints(const JsonText& text, const JsonObject& attributes, const json& solid,
                FileObject& object) {
  const NodeMesh mesh = readMesh(text, attributes, readMeshFrame(solid));
  const auto colors = readColors(mesh);
  for (std::size_t i = 0; i < mesh.points_m.size(); ++i) {
    if (!mesh.points_m[i].allFinite()) continue;
    object.points_m.push_back(mesh.points_m[i]);
    object.colors.push_back(colors[i]);
  }
}

FileObject readObject(const JsonText& text, const JsonObject& attributes, BoxSource source,
                      MeshPoints points) {
  const json solid = readFields(text, attributes, {"position", "bounding_box", "name", "metadata"});
  FileObject object;
  const auto name = solid.find("name");
  if (name != solid.end() && name->is_string()) object.name = name->get<std::string>();
  object.embedding = readEmbedding(text, attributes);
  if (source == BoxSource::kMesh) {
    object.box = fitToMesh(text, attributes, solid);
  } else if (const auto noted = readNotedBox(solid)) {
    object.box = toRotatedBox(*noted);
  } else {
    object.box = readRotatedBox(solid);
  }
  checkBox(object.box);
  if (points == MeshPoints::kRead) readPoints(text, attributes, solid, object);
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

FileObjects readLayer(const JsonText& text, FileLayer layer, BoxSource source, MeshPoints points) {
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
      FileObject object = readObject(text, *attributes, source, points);
      object.id = key;
      read.objects.push_back(std::move(object));
    } catch (const std::runtime_error& e) {
      read.left_out.push_back((key > 0 ? describeNode(key) : "a node without id") + ' ' + e.what());
    }
  }
  return read;
}

}  // namespace

FileObjects loadFileObjects(const std::string& path, FileLayer layer, BoxSource source,
                            MeshPoints points) {
  try {
    return readLayer(JsonText::read(path), layer, source, points);
  } catch (const std::runtime_error& e) {
    throw std::runtime_error("scene graph '" + path + "' " + e.what());
  }
}

}  // namespace tsg::scene_graph
