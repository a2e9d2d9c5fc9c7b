// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/message_conversions.h"

#include <boost/make_shared.hpp>
#include <cmath>
#include <cstring>

#include "task_scene_graph/core/find_by_id.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/image_conversions.h"

namespace tsg::ros_interface {
namespace {

// No map is so large; single precision, which files and meshes have, can hold it.
constexpr double kFarthest_m = 1e9;

/// Also for NaN.
bool isFar(const Eigen::Vector3d& position_m) {
  return !(position_m.cwiseAbs().maxCoeff() <= kFarthest_m) || position_m.hasNaN();
}

/// Track and ObjectPrimitive carry the same fields.
template <typename Message>
ViewStatistics toViews(const Message& message) {
  return {{toStamp(message.best_view.stamp), message.best_view.segment},
          message.best_view_pixels,
          message.mean_distance,
          message.min_distance,
          message.view_spread};
}

template <typename Message>
void copyViews(const ViewStatistics& views, Message& message) {
  message.best_view.stamp = toRosTime(views.best.stamp);
  message.best_view.segment = views.best.segment;
  message.best_view_pixels = views.best_pixels;
  message.mean_distance = static_cast<float>(views.mean_distance_m);
  message.min_distance = static_cast<float>(views.min_distance_m);
  message.view_spread = static_cast<float>(views.spread_rad);
}

bool isSame(const Embedding& a, const std::vector<float>& b) {
  if (static_cast<std::size_t>(a.size()) != b.size()) return false;
  return b.empty() || std::memcmp(a.data(), b.data(), b.size() * sizeof(float)) == 0;
}

SharedEmbedding shareEmbedding(const msg::Place& place, const PlaceGraph& former) {
  const auto known =
      findById(former.places, PlaceId{place.id}, [](const Place& other) { return other.id; });
  if (known != former.places.end() && isSame(*known->embedding, place.embedding)) {
    return known->embedding;
  }
  return toEmbedding(place.embedding);
}

ColorImage toThumbnail(const sensor_msgs::Image& message) {
  if (message.data.empty()) return {};
  return toColorImage(boost::make_shared<const sensor_msgs::Image>(message), "thumbnail");
}

Track toTrack(const msg::Track& message) {
  Track track{{message.id},
              toStamp(message.first_seen),
              toStamp(message.last_seen),
              toEmbedding(message.embedding),
              {},
              toViews(message)};
  for (const auto& observation : message.observations) {
    track.observations.push_back({toStamp(observation.stamp), observation.segment});
  }
  return track;
}

msg::Track toTrackMessage(const Track& track) {
  msg::Track message;
  message.id = track.id.value;
  message.first_seen = toRosTime(track.first_seen);
  message.last_seen = toRosTime(track.last_seen);
  message.embedding = toFloats(track.embedding);
  for (const auto& observation : track.observations) {
    msg::Observation entry;
    entry.stamp = toRosTime(observation.stamp);
    entry.segment = observation.segment;
    message.observations.push_back(entry);
  }
  copyViews(track.views, message);
  return message;
}

/// Arrays of fixed-size tuples and flat arrays have the same layout.
template <typename Tuple, typename Scalar>
void copyFlat(const std::vector<Tuple>& tuples, std::vector<Scalar>& flat) {
  static_assert(sizeof(Tuple) == 3 * sizeof(Scalar));
  flat.resize(tuples.size() * 3);
  if (!flat.empty()) std::memcpy(flat.data(), tuples.data(), flat.size() * sizeof(Scalar));
}

template <typename Tuple, typename Scalar>
std::vector<Tuple> toTuples(const std::vector<Scalar>& flat, const char* name) {
  static_assert(sizeof(Tuple) == 3 * sizeof(Scalar));
  if (flat.size() % 3 != 0) {
    throw InputError("mesh has " + std::to_string(flat.size()) + " values in " + name +
                     ", expected a multiple of 3");
  }
  std::vector<Tuple> tuples(flat.size() / 3);
  if (!flat.empty()) {
    std::memcpy(static_cast<void*>(tuples.data()), flat.data(), flat.size() * sizeof(Scalar));
  }
  return tuples;
}

}  // namespace

sensor_msgs::Image toThumbnailMessage(const ColorImage& thumbnail) {
  if (thumbnail.image.empty()) return {};
  return *toImageMessage(thumbnail.image, "rgb8", thumbnail.stamp, "");
}

TrackedFrame fromMessage(const msg::Tracks& message) {
  TrackedFrame tracked;
  tracked.stamp = toStamp(message.header.stamp);
  for (const auto id : message.segment_tracks) tracked.segment_tracks.push_back({id});
  for (const auto id : message.live) tracked.live.push_back({id});
  for (const auto& track : message.finished) tracked.finished.push_back(toTrack(track));
  for (const auto& track : message.provisional) tracked.provisional.push_back(toTrack(track));
  tracked.is_snapshot = message.is_snapshot != 0;
  return tracked;
}

msg::TracksPtr toMessage(const TrackedFrame& tracked, const std::string& frame) {
  auto message = boost::make_shared<msg::Tracks>();
  message->header.stamp = toRosTime(tracked.stamp);
  message->header.frame_id = frame;
  for (const auto id : tracked.segment_tracks) message->segment_tracks.push_back(id.value);
  for (const auto id : tracked.live) message->live.push_back(id.value);
  for (const auto& track : tracked.finished) message->finished.push_back(toTrackMessage(track));
  for (const auto& track : tracked.provisional) {
    message->provisional.push_back(toTrackMessage(track));
  }
  message->is_snapshot = tracked.is_snapshot ? 1 : 0;
  return message;
}

Mesh fromMessage(const msg::Mesh& message) {
  Mesh mesh;
  mesh.vertices = toTuples<Eigen::Vector3f>(message.vertices, "vertices");
  mesh.colors = toTuples<std::array<std::uint8_t, 3>>(message.colors, "colors");
  mesh.triangles = toTuples<std::array<std::uint32_t, 3>>(message.triangles, "triangles");
  if (mesh.colors.size() != mesh.vertices.size()) {
    throw InputError("mesh has " + std::to_string(mesh.colors.size()) + " colours for " +
                     std::to_string(mesh.vertices.size()) + " vertices");
  }
  for (const auto index : message.triangles) {
    if (index < mesh.vertices.size()) continue;
    throw InputError("mesh triangle names vertex " + std::to_string(index) + ", there are only " +
                     std::to_string(mesh.vertices.size()));
  }
  return mesh;
}

msg::Mesh toMessage(const Mesh& mesh) {
  msg::Mesh message;
  copyFlat(mesh.vertices, message.vertices);
  copyFlat(mesh.colors, message.colors);
  copyFlat(mesh.triangles, message.triangles);
  return message;
}

ObjectPrimitivePtr fromMessage(const msg::ObjectPrimitive& message) {
  auto primitive = std::make_shared<ObjectPrimitive>();
  primitive->id = {message.id};
  primitive->is_provisional = message.is_provisional != 0;
  primitive->track = {message.track_id};
  primitive->mesh = fromMessage(message.mesh);
  primitive->box = toAabb(message.box);
  primitive->oriented_box = toOrientedBox(message.oriented_box);
  primitive->embedding = toEmbedding(message.embedding);
  primitive->first_seen = toStamp(message.first_seen);
  primitive->last_seen = toStamp(message.last_seen);
  primitive->num_observations = message.num_observations;
  primitive->views = toViews(message);
  primitive->thumbnail = toThumbnail(message.thumbnail);
  return primitive;
}

std::vector<ObjectPrimitivePtr> fromMessage(const msg::ObjectPrimitives& message,
                                            const std::string& topic) {
  std::vector<ObjectPrimitivePtr> primitives;
  for (const auto& primitive : message.primitives) {
    try {
      primitives.push_back(fromMessage(primitive));
      const Aabb& box = primitives.back()->box;
      if (!box.isEmpty() && (isFar(box.min()) || isFar(box.max()))) {
        throw InputError("its box is not finite, or reaches beyond 1e9 m");
      }
    } catch (const std::exception& e) {
      throw InputError("object primitive " + std::to_string(primitive.id) + " on " + topic + ": " +
                       e.what());
    }
  }
  return primitives;
}

msg::ObjectPrimitive toMessage(const ObjectPrimitive& primitive) {
  msg::ObjectPrimitive message;
  message.id = primitive.id.value;
  message.is_provisional = primitive.is_provisional ? 1 : 0;
  message.track_id = primitive.track.value;
  message.mesh = toMessage(primitive.mesh);
  message.box = toBoundingBox(primitive.box);
  message.oriented_box = toBoundingBox(primitive.oriented_box);
  message.embedding = toFloats(primitive.embedding);
  message.first_seen = toRosTime(primitive.first_seen);
  message.last_seen = toRosTime(primitive.last_seen);
  message.num_observations = primitive.num_observations;
  copyViews(primitive.views, message);
  message.thumbnail = toThumbnailMessage(primitive.thumbnail);
  return message;
}

msg::ObjectPrimitivesPtr toMessage(const std::vector<ObjectPrimitivePtr>& primitives, Stamp stamp,
                                   const std::string& world_frame) {
  auto message = boost::make_shared<msg::ObjectPrimitives>();
  message->header.stamp = toRosTime(stamp);
  message->header.frame_id = world_frame;
  for (const auto& primitive : primitives) message->primitives.push_back(toMessage(*primitive));
  return message;
}

msg::Place toMessage(const Place& place) {
  msg::Place message;
  message.id = place.id.value;
  message.position = toPoint(place.position_m);
  message.clearance = static_cast<float>(place.clearance_m);
  message.embedding = toFloats(*place.embedding);
  message.num_views = place.num_views;
  return message;
}

msg::PlaceEdge toMessage(const PlaceEdge& edge) {
  msg::PlaceEdge message;
  message.a = edge.a.value;
  message.b = edge.b.value;
  message.clearance = static_cast<float>(edge.clearance_m);
  return message;
}

PlaceGraphPtr fromMessage(const msg::PlaceGraph& message, const PlaceGraph& former) {
  auto graph = std::make_shared<PlaceGraph>();
  graph->stamp = toStamp(message.header.stamp);
  graph->places.reserve(message.places.size());
  graph->edges.reserve(message.edges.size());
  for (const auto& place : message.places) {
    graph->places.push_back({{place.id},
                             toVector(place.position),
                             place.clearance,
                             shareEmbedding(place, former),
                             place.num_views});
  }
  for (const auto& edge : message.edges) {
    graph->edges.push_back({{edge.a}, {edge.b}, edge.clearance});
  }
  return graph;
}

PlaceGraphPtr fromMessage(const msg::PlaceGraph& message, const std::string& topic,
                          const PlaceGraph& former) {
  for (const auto& place : message.places) {
    if (!isFar(toVector(place.position)) && std::isfinite(place.clearance)) continue;
    throw InputError("place " + std::to_string(place.id) + " on " + topic +
                     " has a position or clearance that is not finite, or beyond 1e9 m");
  }
  return fromMessage(message, former);
}

msg::PlaceGraphPtr toMessage(const PlaceGraph& graph, const std::string& world_frame) {
  auto message = boost::make_shared<msg::PlaceGraph>();
  message->header.stamp = toRosTime(graph.stamp);
  message->header.frame_id = world_frame;
  for (const auto& place : graph.places) message->places.push_back(toMessage(place));
  for (const auto& edge : graph.edges) message->edges.push_back(toMessage(edge));
  return message;
}

}  // namespace tsg::ros_interface
