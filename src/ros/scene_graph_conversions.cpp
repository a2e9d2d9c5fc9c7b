// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/scene_graph_conversions.h"

#include <boost/make_shared.hpp>

#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/message_conversions.h"

namespace tsg::ros_interface {
namespace {

template <typename Ids>
std::vector<std::uint64_t> toValues(const Ids& ids) {
  std::vector<std::uint64_t> values;
  for (const auto id : ids) values.push_back(id.value);
  return values;
}

template <typename Id>
std::vector<Id> toIds(const std::vector<std::uint64_t>& values) {
  std::vector<Id> ids;
  for (const auto value : values) ids.push_back({value});
  return ids;
}

msg::SceneObject toObjectMessage(const scene_graph::SceneObject& object, bool with_embeddings) {
  msg::SceneObject message;
  message.id = object.id.value;
  message.task = object.task;
  message.task_index = object.task_index;
  message.score = static_cast<float>(object.score);
  message.box = toBoundingBox(object.box);
  message.oriented_box = toBoundingBox(object.oriented_box);
  message.position = toPoint(object.position_m);
  message.primitives = toValues(object.primitives);
  if (with_embeddings) message.embedding = toFloats(object.embedding);
  message.first_seen = toRosTime(object.first_seen);
  message.last_seen = toRosTime(object.last_seen);
  message.place = object.place.value;
  return message;
}

scene_graph::SceneObject toObject(const msg::SceneObject& message) {
  scene_graph::SceneObject object;
  object.id = {message.id};
  object.task = message.task;
  object.task_index = message.task_index;
  object.score = message.score;
  object.box = toAabb(message.box);
  object.oriented_box = toOrientedBox(message.oriented_box);
  object.position_m = toVector(message.position);
  object.primitives = toIds<PrimitiveId>(message.primitives);
  object.embedding = toEmbedding(message.embedding);
  object.first_seen = toStamp(message.first_seen);
  object.last_seen = toStamp(message.last_seen);
  object.place = {message.place};
  return object;
}

msg::Region toRegionMessage(const scene_graph::Region& region, bool with_embeddings) {
  msg::Region message;
  message.id = region.id.value;
  message.task = region.task;
  message.task_index = region.task_index;
  message.score = static_cast<float>(region.score);
  message.position = toPoint(region.position_m);
  message.places = toValues(region.places);
  if (with_embeddings) message.embedding = toFloats(region.embedding);
  message.area = static_cast<float>(region.area_m2);
  for (const Eigen::Vector2d& corner_m : region.footprint_m) {
    geometry_msgs::Point32 point;
    point.x = static_cast<float>(corner_m.x());
    point.y = static_cast<float>(corner_m.y());
    point.z = static_cast<float>(region.position_m.z());
    message.footprint.push_back(point);
  }
  message.doors = toValues(region.doors);
  message.objects = toValues(region.objects);
  return message;
}

scene_graph::Region toRegion(const msg::Region& message) {
  scene_graph::Region region;
  region.id = {message.id};
  region.task = message.task;
  region.task_index = message.task_index;
  region.score = message.score;
  region.position_m = toVector(message.position);
  region.places = toIds<PlaceId>(message.places);
  region.embedding = toEmbedding(message.embedding);
  region.area_m2 = message.area;
  for (const auto& point : message.footprint) region.footprint_m.emplace_back(point.x, point.y);
  region.doors = toIds<PlaceId>(message.doors);
  region.objects = toIds<ObjectId>(message.objects);
  return region;
}

msg::RegionEdge toRegionEdgeMessage(const scene_graph::RegionEdge& edge) {
  msg::RegionEdge message;
  message.a = edge.a.value;
  message.b = edge.b.value;
  message.passage = static_cast<float>(edge.passage_m);
  message.merge_loss = static_cast<float>(edge.merge_loss);
  message.merge_threshold = static_cast<float>(edge.merge_threshold);
  return message;
}

void addPlaces(const PlaceGraph& graph, bool with_embeddings, msg::SceneGraph& message) {
  for (const auto& place : graph.places) {
    message.places.push_back(toMessage(place));
    if (!with_embeddings) message.places.back().embedding.clear();
  }
  for (const auto& edge : graph.edges) message.place_edges.push_back(toMessage(edge));
}

}  // namespace

msg::SceneGraphPtr toMessage(const scene_graph::SceneGraph& graph, const std::string& world_frame,
                             bool with_embeddings) {
  auto message = boost::make_shared<msg::SceneGraph>();
  message->header.stamp = toRosTime(graph.stamp);
  message->header.frame_id = world_frame;
  message->object_tasks = graph.object_tasks;
  message->place_tasks = graph.place_tasks;
  for (const auto& object : graph.objects) {
    message->objects.push_back(toObjectMessage(object, with_embeddings));
  }
  if (graph.places != nullptr) addPlaces(*graph.places, with_embeddings, *message);
  for (const auto& region : graph.regions) {
    message->regions.push_back(toRegionMessage(region, with_embeddings));
  }
  for (const auto& edge : graph.region_edges) {
    message->region_edges.push_back(toRegionEdgeMessage(edge));
  }
  return message;
}

scene_graph::SceneGraph fromMessage(const msg::SceneGraph& message) {
  scene_graph::SceneGraph graph;
  graph.stamp = toStamp(message.header.stamp);
  graph.world_frame = message.header.frame_id;
  graph.object_tasks = message.object_tasks;
  graph.place_tasks = message.place_tasks;
  for (const auto& object : message.objects) graph.objects.push_back(toObject(object));
  msg::PlaceGraph places;
  places.header = message.header;
  places.places = message.places;
  places.edges = message.place_edges;
  graph.places = fromMessage(places);
  for (const auto& region : message.regions) graph.regions.push_back(toRegion(region));
  for (const auto& edge : message.region_edges) {
    graph.region_edges.push_back(
        {{edge.a}, {edge.b}, edge.passage, edge.merge_loss, edge.merge_threshold});
  }
  return graph;
}

}  // namespace tsg::ros_interface
