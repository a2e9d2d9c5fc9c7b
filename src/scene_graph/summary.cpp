// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "json_stream.h"
#include "task_scene_graph/core/files.h"
#include "task_scene_graph/scene_graph/files.h"

namespace tsg::scene_graph {
namespace {

using Json = nlohmann::json;

/// To 4 decimals: tenths of a millimetre.
double round4(double value) { return std::round(value * 1e4) / 1e4; }

Json toJson(const Eigen::Vector3d& v) { return {round4(v.x()), round4(v.y()), round4(v.z())}; }

Json toJson(const OrientedBox& box) {
  return {{"center_m", toJson(box.center_m)},
          {"size_m", toJson(box.size_m)},
          {"yaw_rad", round4(box.yaw_rad)}};
}

Json toJson(const SceneObject& object) {
  return {{"id", object.id.value},
          {"task", object.task},
          {"score", round4(object.score)},
          {"position_m", toJson(object.position_m)},
          {"orientation_xyzw", {0, 0, 0, 1}},
          {"box_min_m", toJson(Eigen::Vector3d(object.box.min()))},
          {"box_max_m", toJson(Eigen::Vector3d(object.box.max()))},
          {"oriented_box", toJson(object.oriented_box)},
          {"place", object.place.isValid() ? Json(object.place.value) : Json()},
          {"num_primitives", object.primitives.size()},
          {"first_seen_s", object.first_seen.seconds()},
          {"last_seen_s", object.last_seen.seconds()}};
}

Json toJson(const std::vector<Eigen::Vector2d>& outline_m) {
  Json corners = Json::array();
  for (const Eigen::Vector2d& corner_m : outline_m) {
    corners.push_back({round4(corner_m.x()), round4(corner_m.y())});
  }
  return corners;
}

Json toIdsJson(const std::vector<PlaceId>& places) {
  Json ids = Json::array();
  for (const PlaceId place : places) ids.push_back(place.value);
  return ids;
}

Json findNeighbours(const SceneGraph& graph, RegionId id) {
  Json neighbours = Json::array();
  for (const auto& edge : graph.region_edges) {
    if (edge.a == id) neighbours.push_back(edge.b.value);
    if (edge.b == id) neighbours.push_back(edge.a.value);
  }
  return neighbours;
}

Json toJson(const SceneGraph& graph, const Region& region) {
  return {{"id", region.id.value},
          {"task", region.task_index >= 0 ? Json(region.task) : Json()},
          {"score", round4(region.score)},
          {"position_m", toJson(region.position_m)},
          {"num_places", region.places.size()},
          {"area_m2", round4(region.area_m2)},
          {"footprint_m", toJson(region.footprint_m)},
          {"doors", toIdsJson(region.doors)},
          {"neighbours", findNeighbours(graph, region.id)}};
}

/// [{task, <what>: how many of `items` have it}], in the order of the tasks, zeros included.
template <typename Items>
Json countPerTask(const std::vector<std::string>& tasks, const Items& items, const char* what) {
  Json counts = Json::array();
  for (std::size_t t = 0; t < tasks.size(); ++t) {
    const auto count = std::count_if(items.begin(), items.end(), [&](const auto& item) {
      return item.task_index == static_cast<int>(t);
    });
    counts.push_back({{"task", tasks[t]}, {what, count}});
  }
  return counts;
}

Json makeHead(const SceneGraph& graph) {
  ConfigJson<Json> config;
  SceneGraphConfig::visit(graph.config, config);
  const Json counts = {{"objects", graph.objects.size()},
                       {"rooms", graph.regions.size()},
                       {"places", graph.places->places.size()},
                       {"primitives", graph.primitives.size()}};
  return {{"frame", graph.world_frame},
          {"stamp_s", graph.stamp.seconds()},
          {"config", config.map},
          {"counts", counts},
          {"objects_per_task", countPerTask(graph.object_tasks, graph.objects, "objects")},
          {"rooms_per_task", countPerTask(graph.place_tasks, graph.regions, "rooms")}};
}

void writeRoom(std::ostream& stream, const Json& head, const SceneGraph& graph,
               const std::vector<RegionId>& region_of_objects, RegionId id) {
  JsonObjectStream out(stream, head);
  out.beginList("objects");
  for (std::size_t i = 0; i < graph.objects.size(); ++i) {
    if (region_of_objects[i] == id) out.addElement(toJson(graph.objects[i]));
  }
  out.endList();
  out.finish();
}

void writeGraph(std::ostream& stream, const SceneGraph& graph) {
  const std::vector<RegionId> region_of_objects = computeRegionOfObjects(graph);
  const auto addRoom = [&](JsonObjectStream& out, const Json& head, RegionId id) {
    out.addElementWith([&](std::ostream& s) { writeRoom(s, head, graph, region_of_objects, id); });
  };
  JsonObjectStream out(stream, makeHead(graph));
  out.beginList("rooms");
  for (const auto& region : graph.regions) addRoom(out, toJson(graph, region), region.id);
  const auto& regions = region_of_objects;
  if (std::find(regions.begin(), regions.end(), RegionId{}) != regions.end()) {
    addRoom(out, {{"id", nullptr}, {"task", nullptr}}, RegionId{});
  }
  out.endList();
  out.finish();
  stream << '\n';
}

}  // namespace

void writeSummary(const std::string& path, const SceneGraph& graph) {
  writeFileAtomically(path, [&](std::ostream& stream) { writeGraph(stream, graph); });
}

}  // namespace tsg::scene_graph
