// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "json_stream.h"
#include "spark_dsg_format.h"
#include "task_scene_graph/core/files.h"
#include "task_scene_graph/scene_graph/files.h"

// The layout is that of spark_dsg 1.1.3: a node is {id, layer, partition, attributes}, its id a
// character in the top byte and a number below it. Attributes that are left out get that library's
// defaults.
namespace tsg::scene_graph {
namespace {

using Json = nlohmann::json;

constexpr int kSegments = 1;
constexpr int kObjects = 2;
constexpr int kPlaces = 3;
constexpr int kRooms = 4;

std::uint64_t toNodeId(PrimitiveId id) { return makeNodeId('s', id.value); }
std::uint64_t toNodeId(ObjectId id) { return makeNodeId('O', id.value); }
std::uint64_t toNodeId(PlaceId id) { return makeNodeId('p', id.value); }
std::uint64_t toNodeId(RegionId id) { return makeNodeId('l', id.value); }

Json toJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Json toJson(Stamp stamp) { return static_cast<std::uint64_t>(std::max<std::int64_t>(0, stamp.ns)); }
Json makeIdentity() { return {{"w", 1}, {"x", 0}, {"y", 0}, {"z", 0}}; }

Json toJson(const Aabb& box) {
  return {{"type", "AABB"},
          {"dimensions", toJson(Eigen::Vector3d(box.sizes()))},
          {"world_P_center", toJson(Eigen::Vector3d(box.center()))},
          {"world_R_center", makeIdentity()}};
}

/// For the metadata: that library's own box of a node stays the axis-aligned one.
Json toJson(const OrientedBox& box) {
  return {
      {"center_m", toJson(box.center_m)}, {"size_m", toJson(box.size_m)}, {"yaw_rad", box.yaw_rad}};
}

/// Coordinates to the tenth of a millimetre: meshes are large.
double roundCoordinate(double value_m) { return std::round(value_m * 1e4) / 1e4; }

/// Vertices relative to the centre of the node's box, as that library's viewers expect.
Json toJson(const Mesh& mesh, const Eigen::Vector3d& center_m) {
  Json points = Json::array();
  for (const auto& vertex : mesh.vertices) {
    const Eigen::Vector3d p_box = vertex.cast<double>() - center_m;
    points.push_back(
        {roundCoordinate(p_box.x()), roundCoordinate(p_box.y()), roundCoordinate(p_box.z())});
  }
  Json colors = Json::array();
  for (const auto& [r, g, b] : mesh.colors) {
    colors.push_back({{"r", r}, {"g", g}, {"b", b}, {"a", 255}});
  }
  return {{"points", points},
          {"colors", colors},
          {"faces", mesh.triangles},
          {"has_colors", mesh.colors.size() == mesh.vertices.size()},
          {"has_timestamps", false},
          {"has_labels", false},
          {"has_first_seen_stamps", false}};
}

/// A JSON object, which has fields, with one more.
std::string addField(std::string object, const char* name, const std::string& value) {
  object.back() = ',';
  return object + '"' + name + "\":" + value + '}';
}

class Writer {
 public:
  Writer(const SceneGraph& graph, const SparkDsgOptions& options, std::ostream& stream)
      : graph_(graph), options_(options), stream_(stream) {
    for (const auto& primitive : graph.primitives) primitives_[primitive->id] = primitive.get();
  }

  void write() {
    JsonObjectStream out(stream_, makeHead());
    out.beginList("nodes");
    if (options_.primitives) {
      for (const auto& primitive : graph_.primitives) addNode(out, *primitive, kSegments);
    }
    for (const auto& object : graph_.objects) addNode(out, object, kObjects);
    for (const auto& place : graph_.places->places) addNode(out, place, kPlaces);
    for (const auto& region : graph_.regions) addNode(out, region, kRooms);
    out.endList();
    out.beginList("edges");
    writeEdgesWithin(out);
    writeEdgesBetween(out);
    out.endList();
    out.finish();
  }

 private:
  Json makeHead() const {
    Json names = {{"OBJECTS", kObjects}, {"PLACES", kPlaces}, {"ROOMS", kRooms}};
    if (options_.primitives) names["SEGMENTS"] = kSegments;
    Json keys = Json::array();
    for (auto& name : names) {
      name = {{"layer", name.get<int>()}, {"partition", 0}};
      keys.push_back(name);
    }
    return {{"SPARK_DSG_header",
             {{"project_name", "main"}, {"version", {{"major", 1}, {"minor", 1}, {"patch", 3}}}}},
            {"directed", false},
            {"multigraph", false},
            {"layer_keys", keys},
            {"layer_names", names},
            {"metadata", makeMetadata()}};
  }

  Json makeMetadata() const {
    ConfigJson<Json> config;
    SceneGraphConfig::visit(graph_.config, config);
    return {{"object_tasks", graph_.object_tasks},
            {"place_tasks", graph_.place_tasks},
            {"config", config.map},
            {"stamp_ns", graph_.stamp.ns},
            {"frame", graph_.world_frame}};
  }

  /// Embeddings are written apart, in single precision: every bit in half the characters.
  template <typename Item>
  void addNode(JsonObjectStream& out, const Item& item, int layer) const {
    std::string attributes = toText(makeAttributes(item));
    if (options_.embeddings && item.embedding.size() > 0) {
      std::string feature;
      appendFeature(item.embedding, FeatureForm::kColumn, feature);
      attributes = addField(std::move(attributes), "semantic_feature", feature);
    }
    const Json node = {{"id", toNodeId(item.id)}, {"layer", layer}, {"partition", 0}};
    out.addElementWith(
        [&](std::ostream& stream) { stream << addField(toText(node), "attributes", attributes); });
  }

  /// What every node has.
  static Json makeCommon(const char* type, const Eigen::Vector3d& position_m) {
    return {{"type", type}, {"position", toJson(position_m)}, {"is_active", false}};
  }

  static Json makeSolid(const Eigen::Vector3d& position_m, const Aabb& box, Stamp first_seen,
                        Stamp last_seen) {
    Json attributes = makeCommon("KhronosObjectAttributes", position_m);
    attributes["bounding_box"] = toJson(box);
    attributes["first_observed_ns"] = {toJson(first_seen)};
    attributes["last_observed_ns"] = {toJson(last_seen)};
    attributes["last_update_time_ns"] = toJson(last_seen);
    attributes["world_R_object"] = makeIdentity();
    return attributes;
  }

  Json makeAttributes(const ObjectPrimitive& primitive) const {
    Json attributes =
        makeSolid(primitive.box.center(), primitive.box, primitive.first_seen, primitive.last_seen);
    attributes["metadata"] = {{"track", primitive.track.value},
                              {"num_observations", primitive.num_observations},
                              {"oriented_box", toJson(primitive.oriented_box)}};
    if (options_.meshes) attributes["mesh"] = toJson(primitive.mesh, primitive.box.center());
    return attributes;
  }

  Json makeAttributes(const SceneObject& object) const {
    Json attributes = makeSolid(object.position_m, object.box, object.first_seen, object.last_seen);
    attributes["name"] = object.task;
    attributes["semantic_label"] = object.task_index;
    attributes["metadata"] = {{"score", object.score},
                              {"oriented_box", toJson(object.oriented_box)}};
    for (const PrimitiveId id : object.primitives) {
      attributes["metadata"]["primitives"].push_back(id.value);
    }
    if (options_.meshes) attributes["mesh"] = toJson(joinMeshes(object), object.box.center());
    return attributes;
  }

  Json makeAttributes(const Place& place) const {
    Json attributes = makeCommon("PlaceNodeAttributes", place.position_m);
    attributes["distance"] = place.clearance_m;
    attributes["real_place"] = true;
    attributes["last_update_time_ns"] = toJson(graph_.places->stamp);
    attributes["metadata"] = {{"num_views", place.num_views}};
    return attributes;
  }

  Json makeAttributes(const Region& region) const {
    Json attributes = makeCommon("RoomNodeAttributes", region.position_m);
    attributes["name"] = region.task;
    if (region.task_index >= 0) attributes["semantic_label"] = region.task_index;
    attributes["last_update_time_ns"] = toJson(graph_.places->stamp);
    Json footprint = Json::array();
    for (const Eigen::Vector2d& corner_m : region.footprint_m) {
      footprint.push_back({corner_m.x(), corner_m.y()});
    }
    attributes["metadata"] = {
        {"score", region.score}, {"area_m2", region.area_m2}, {"footprint_m", footprint}};
    return attributes;
  }

  Mesh joinMeshes(const SceneObject& object) const {
    Mesh mesh;
    for (const PrimitiveId id : object.primitives) mesh.append(primitives_.at(id)->mesh);
    return mesh;
  }

  static void addEdge(JsonObjectStream& out, std::uint64_t source, std::uint64_t target,
                      const EdgeInfo& info = {}) {
    std::string text;
    appendEdge(source, target, info, text);
    out.addElementWith([&](std::ostream& stream) { stream << text; });
  }

  void writeEdgesWithin(JsonObjectStream& out) const {
    for (const auto& edge : graph_.places->edges) {
      addEdge(out, toNodeId(edge.a), toNodeId(edge.b), {edge.clearance_m, true});
    }
    for (const auto& edge : graph_.region_edges) addEdge(out, toNodeId(edge.a), toNodeId(edge.b));
  }

  /// Parents first: region -> place -> object -> primitive.
  void writeEdgesBetween(JsonObjectStream& out) const {
    for (const auto& region : graph_.regions) {
      for (const PlaceId place : region.places) addEdge(out, toNodeId(region.id), toNodeId(place));
    }
    for (const auto& object : graph_.objects) {
      if (object.place.isValid()) addEdge(out, toNodeId(object.place), toNodeId(object.id));
      if (!options_.primitives) continue;
      for (const PrimitiveId id : object.primitives) {
        addEdge(out, toNodeId(object.id), toNodeId(id));
      }
    }
  }

  const SceneGraph& graph_;
  const SparkDsgOptions& options_;
  std::ostream& stream_;
  std::map<PrimitiveId, const ObjectPrimitive*> primitives_;
};

}  // namespace

void writeSparkDsg(const std::string& path, const SceneGraph& graph,
                   const SparkDsgOptions& options) {
  writeFileAtomically(path, [&](std::ostream& stream) { Writer(graph, options, stream).write(); });
}

}  // namespace tsg::scene_graph
