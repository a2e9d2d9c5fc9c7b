// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <ros/serialization.h>
#include <task_scene_graph/SceneGraphTuningConfig.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/ros/frame_matcher.h"
#include "task_scene_graph/ros/mesh_markers.h"
#include "task_scene_graph/ros/scene_graph_conversions.h"
#include "task_scene_graph/ros/scene_graph_markers.h"

namespace tsg::ros_interface {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

scene_graph::SceneGraph makeGraph() {
  scene_graph::SceneGraph graph;
  graph.stamp = {1234567890};
  graph.object_tasks = {"read a book", "sit down"};
  graph.place_tasks = {"kitchen"};
  scene_graph::SceneObject object;
  object.id = {3};
  object.task = "sit down";
  object.task_index = 1;
  object.score = 0.5;
  object.box = makeAabb({0, 0, 0}, {1, 2, 3});
  object.position_m = {0.5, 1.0, 1.5};
  object.primitives = {{4}, {9}};
  object.embedding = Embedding::Unit(3, 1);
  object.first_seen = {1};
  object.last_seen = {2000000001};
  object.place = {7};
  graph.objects = {object};
  auto places = std::make_shared<PlaceGraph>();
  places->stamp = graph.stamp;
  places->places = {{{7}, {0, 0, 1}, 0.5, Embedding(Embedding::Unit(3, 0)), 2},
                    {{8}, {1, 0, 1}, 0.75, {}, 0}};
  places->edges = {{{7}, {8}, 0.25}};
  graph.places = places;
  scene_graph::Region region;
  region.id = {1};
  region.task = "kitchen";
  region.task_index = 0;
  region.score = 0.25;
  region.position_m = {0, 0, 1};
  region.places = {{7}};
  region.embedding = Embedding::Unit(3, 0);
  region.area_m2 = 0.5;
  region.footprint_m = {{0, 0}, {1, 0}, {1, 0.5}, {0, 0.5}};
  region.doors = {{7}};
  region.objects = {{1}};
  scene_graph::Region other = region;
  other.id = {2};
  other.task = "";
  other.task_index = -1;
  other.places = {{8}};
  graph.regions = {region, other};
  graph.region_edges = {{{1}, {2}, 0.25, 2.0, 0.5}};
  return graph;
}

std::string bytesOf(const msg::SceneGraph& message) {
  const auto bytes = ::ros::serialization::serializeMessage(message);
  return {reinterpret_cast<const char*>(bytes.buf.get()), bytes.num_bytes};
}

TEST(SceneGraphConversion, RoundTripGivesTheSameMessage) {
  const auto message = toMessage(makeGraph(), "world", true);
  const scene_graph::SceneGraph received = fromMessage(*message);
  EXPECT_EQ(bytesOf(*toMessage(received, "world", true)), bytesOf(*message));
  ASSERT_EQ(received.objects.size(), 1U);
  EXPECT_EQ(received.objects[0].last_seen.ns, 2000000001);
  EXPECT_EQ(received.objects[0].primitives[1].value, 9U);
  EXPECT_TRUE(received.objects[0].box.isApprox(makeGraph().objects[0].box));
  ASSERT_EQ(received.regions.size(), 2U);
  EXPECT_EQ(received.regions[1].task_index, -1);
  EXPECT_EQ(received.region_edges[0].b.value, 2U);
  EXPECT_EQ(received.region_edges[0].passage_m, 0.25);
  EXPECT_EQ(received.region_edges[0].merge_loss, 2.0);
  EXPECT_EQ(received.region_edges[0].merge_threshold, 0.5);
  EXPECT_EQ(received.regions[0].area_m2, 0.5);
  EXPECT_EQ(received.regions[0].footprint_m[2], Eigen::Vector2d(1, 0.5));
  EXPECT_EQ(received.regions[0].doors, (std::vector<PlaceId>{{7}}));
  EXPECT_EQ(received.regions[0].objects, (std::vector<ObjectId>{{1}}));
  EXPECT_EQ(received.places->edges[0].clearance_m, 0.25);
}

TEST(SceneGraphConversion, EmbeddingsOnlyOnDemand) {
  const auto with = toMessage(makeGraph(), "world", true);
  EXPECT_EQ(with->objects[0].embedding.size(), 3U);
  EXPECT_EQ(with->places[0].embedding.size(), 3U);
  EXPECT_EQ(with->regions[0].embedding.size(), 3U);
  const auto without = toMessage(makeGraph(), "world", false);
  EXPECT_TRUE(without->objects[0].embedding.empty());
  EXPECT_TRUE(without->places[0].embedding.empty());
  EXPECT_TRUE(without->regions[0].embedding.empty());
}

const Marker* findMarker(const MarkerArray& array, const std::string& ns, int id) {
  for (const auto& marker : array.markers) {
    if (marker.ns == ns && marker.id == id) return &marker;
  }
  return nullptr;
}

TEST(SceneGraphMarkers, BoxStaysAndNodesAreLifted) {
  const MarkerConfig config;
  SceneGraphMarkers markers(config, "world");
  TaskNumbers numbers;
  const MarkerArray array = markers.update(makeGraph(), numbers);
  const Marker* box = findMarker(array, "object_boxes", 3);
  ASSERT_NE(box, nullptr);
  EXPECT_EQ(box->scale.y, 2.0);
  EXPECT_EQ(box->pose.position.z, 1.5);
  const Marker* frame = findMarker(array, "object_frames", 3);
  ASSERT_NE(frame, nullptr);
  EXPECT_EQ(frame->points.size(), 24U);
  double length_m = 0.0;
  for (std::size_t i = 0; i + 1 < frame->points.size(); i += 2) {
    const auto& a = frame->points[i];
    const auto& b = frame->points[i + 1];
    length_m += std::abs(a.x - b.x) + std::abs(a.y - b.y) + std::abs(a.z - b.z);
  }
  EXPECT_DOUBLE_EQ(length_m, 4.0 * (1.0 + 2.0 + 3.0));
  const Marker* node = findMarker(array, "object_nodes", 3);
  ASSERT_NE(node, nullptr);
  EXPECT_DOUBLE_EQ(node->pose.position.z, 1.5 + config.object_lift_m);
  const Marker* label = findMarker(array, "object_labels", 3);
  ASSERT_NE(label, nullptr);
  EXPECT_EQ(label->text, "sit down");
  const Marker* places = findMarker(array, "places", 0);
  ASSERT_NE(places, nullptr);
  ASSERT_EQ(places->points.size(), 2U);
  EXPECT_DOUBLE_EQ(places->points[0].z, 1.0 + config.place_lift_m);
  EXPECT_EQ(findMarker(array, "region_labels", 1)->text, "kitchen");
  EXPECT_EQ(findMarker(array, "region_labels", 2)->text, "region 2");
}

TEST(SceneGraphMarkers, FillTheFootprintOfARegion) {
  scene_graph::SceneGraph graph = makeGraph();
  // An L of 3 m2: a corner of 1 x 1 m is missing from 2 x 2 m.
  graph.regions[0].footprint_m = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  SceneGraphMarkers markers(MarkerConfig{}, "world");
  TaskNumbers numbers;
  const MarkerArray array = markers.update(graph, numbers);
  const Marker* floor = findMarker(array, "region_floors", 1);
  ASSERT_NE(floor, nullptr);
  ASSERT_EQ(floor->points.size() % 3, 0U);
  double area_m2 = 0.0;
  for (std::size_t i = 0; i < floor->points.size(); i += 3) {
    const auto& a = floor->points[i];
    const auto& b = floor->points[i + 1];
    const auto& c = floor->points[i + 2];
    const double twice_m2 = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    EXPECT_GT(twice_m2, 0.0);  // its front is up: rviz shows it lit from above
    area_m2 += 0.5 * twice_m2;
    EXPECT_EQ(a.z, graph.regions[0].position_m.z());
    EXPECT_FALSE((a.x + b.x + c.x) / 3 > 1.0 && (a.y + b.y + c.y) / 3 > 1.0);
  }
  EXPECT_NEAR(area_m2, 3.0, 1e-6);
  ASSERT_NE(findMarker(array, "region_outlines", 1), nullptr);
  EXPECT_EQ(findMarker(array, "region_outlines", 1)->points.size(), 12U);
}

TEST(SceneGraphMarkers, WhatIsGoneIsDeletedOnce) {
  SceneGraphMarkers markers(MarkerConfig{}, "world");
  TaskNumbers numbers;
  markers.update(makeGraph(), numbers);
  scene_graph::SceneGraph empty;
  empty.places = std::make_shared<PlaceGraph>();
  const MarkerArray second = markers.update(empty, numbers);
  const Marker* box = findMarker(second, "object_boxes", 3);
  ASSERT_NE(box, nullptr);
  EXPECT_EQ(box->action, Marker::DELETE);
  EXPECT_EQ(std::count_if(second.markers.begin(), second.markers.end(),
                          [](const Marker& marker) { return marker.action == Marker::ADD; }),
            0);
  EXPECT_TRUE(markers.update(empty, numbers).markers.empty());
}

/// What a viewer shows that took these messages.
class Picture {
 public:
  void take(const MarkerArray& array) {
    for (const auto& marker : array.markers) {
      if (marker.action == Marker::DELETEALL) shown_.clear();
      if (marker.action == Marker::DELETE) {
        EXPECT_EQ(shown_.erase({marker.ns, marker.id}), 1U);
      }
      if (marker.action == Marker::ADD) shown_[{marker.ns, marker.id}] = marker;
    }
  }
  bool operator==(const Picture& other) const { return shown_ == other.shown_; }

 private:
  std::map<std::pair<std::string, int>, Marker> shown_;
};

/// Objects, places in a chain, and regions, some of each, at random positions.
scene_graph::SceneGraph makeRandomGraph(std::mt19937& random, std::size_t max_places) {
  const auto draw = [&](std::size_t below) {
    return std::uniform_int_distribution<std::size_t>(0, below - 1)(random);
  };
  scene_graph::SceneGraph graph;
  graph.object_tasks = {"a", "b"};
  auto places = std::make_shared<PlaceGraph>();
  for (std::uint64_t id = 1; id <= max_places; ++id) {
    if (draw(5) == 0) continue;
    const PlaceId before = places->places.empty() ? PlaceId{} : places->places.back().id;
    places->places.push_back({{id}, {static_cast<double>(draw(2)), 0, 0}, 0.5, {}, 0});
    if (before.isValid() && draw(2) == 0) places->edges.push_back({before, {id}, 0.25});
  }
  for (std::uint64_t id = 1; id <= 70; ++id) {
    if (draw(2) == 0) continue;
    scene_graph::SceneObject object;
    object.id = {id};
    object.task_index = static_cast<int>(draw(2));
    object.task = graph.object_tasks[static_cast<std::size_t>(object.task_index)];
    object.box = makeAabb({0, 0, 0}, {1, 1, static_cast<double>(1 + draw(2))});
    if (!places->places.empty()) object.place = places->places[draw(places->places.size())].id;
    graph.objects.push_back(object);
  }
  for (std::uint64_t id = 1; id <= 4; ++id) {
    scene_graph::Region region;
    region.id = {id};
    region.footprint_m = {{0, 0}, {1, 0}, {1, static_cast<double>(1 + draw(2))}};
    graph.regions.push_back(region);
  }
  for (const auto& place : places->places) {
    if (const std::size_t region = draw(5); region < 4) {
      graph.regions[region].places.push_back(place.id);
    }
  }
  if (draw(2) == 0) graph.region_edges = {{{1}, {3}, 0.5, 0.0, 0.0}};
  graph.places = places;
  return graph;
}

TEST(SceneGraphMarkers, ChangesOneAfterTheOtherGiveThePictureOfTheNewestGraph) {
  std::mt19937 random(4);
  SceneGraphMarkers markers(MarkerConfig{}, "world");
  TaskNumbers numbers;
  Picture follower;
  for (int round = 0; round < 60; ++round) {
    const auto graph = makeRandomGraph(random, 1 + static_cast<std::size_t>(round) % 7 * 50);
    follower.take(markers.update(graph, numbers));
    Picture fresh;
    SceneGraphMarkers anew(MarkerConfig{}, "world");
    fresh.take(anew.update(graph, numbers));
    EXPECT_TRUE(follower == fresh) << round;
    Picture late = follower;
    late.take(markers.all());
    EXPECT_TRUE(late == fresh) << round;
    EXPECT_TRUE(markers.update(graph, numbers).markers.empty());
  }
}

TEST(SceneGraphMarkers, ObjectsOfATaskThatStandTogetherHaveOneLabelWithTheirNumber) {
  scene_graph::SceneGraph graph = makeGraph();
  const scene_graph::SceneObject first = graph.objects.front();
  const auto addObject = [&](std::uint64_t id, int task, double x_m) {
    scene_graph::SceneObject object = first;
    object.id = {id};
    object.task_index = task;
    object.task = graph.object_tasks[static_cast<std::size_t>(task)];
    object.box = makeAabb({x_m, 0, 0}, {x_m + 0.5, 0.5, 0.1 * static_cast<double>(id)});
    graph.objects.push_back(object);
  };
  graph.objects.clear();
  addObject(1, 0, 0.0);
  addObject(2, 0, 0.9);
  addObject(3, 1, 1.0);  // another task
  addObject(4, 0, 1.8);  // joined by way of 2
  addObject(5, 0, 9.0);
  SceneGraphMarkers markers(MarkerConfig{}, "world");
  TaskNumbers numbers;
  const MarkerArray array = markers.update(graph, numbers);
  for (const auto* ns : {"object_labels", "object_box_labels"}) {
    ASSERT_NE(findMarker(array, ns, 1), nullptr);
    EXPECT_EQ(findMarker(array, ns, 1)->text, "read a book (3)");
    EXPECT_EQ(findMarker(array, ns, 3)->text, "sit down");
    EXPECT_EQ(findMarker(array, ns, 5)->text, "read a book");
    EXPECT_EQ(findMarker(array, ns, 2), nullptr);
    EXPECT_EQ(findMarker(array, ns, 4), nullptr);
  }
  const Marker* label = findMarker(array, "object_box_labels", 1);
  EXPECT_NEAR(label->pose.position.x, 1.15, 1e-9);
  EXPECT_GT(label->pose.position.z, 0.4);
  EXPECT_LT(label->pose.position.z, 0.7);
}

TEST(SceneGraphMarkers, ADifferentLiftDrawsAllOfItThere) {
  SceneGraphMarkers markers(MarkerConfig{}, "world");
  TaskNumbers numbers;
  markers.update(makeGraph(), numbers);
  MarkerConfig higher;
  higher.object_lift_m = 5.0;
  markers.setConfig(higher);
  const MarkerArray changes = markers.update(makeGraph(), numbers);
  ASSERT_NE(findMarker(changes, "object_nodes", 3), nullptr);
  EXPECT_DOUBLE_EQ(findMarker(changes, "object_nodes", 3)->pose.position.z, 1.5 + 5.0);
  for (const auto& marker : changes.markers) EXPECT_EQ(marker.action, Marker::ADD);
}

TEST(SceneGraphMarkers, APlaceThatMovesDrawsItsNeighboursByIdOnly) {
  scene_graph::SceneGraph graph;
  auto places = std::make_shared<PlaceGraph>();
  for (std::uint64_t id = 1; id <= 1000; ++id) {
    places->places.push_back({{id}, {static_cast<double>(id), 0, 0}, 0.5, {}, 0});
    if (id > 1) places->edges.push_back({{id - 1}, {id}, 0.25});
  }
  graph.places = places;
  SceneGraphMarkers markers(MarkerConfig{}, "world");
  TaskNumbers numbers;
  markers.update(graph, numbers);
  auto moved = std::make_shared<PlaceGraph>(*places);
  moved->places[500].position_m.y() = 1.0;
  graph.places = moved;
  const MarkerArray changes = markers.update(graph, numbers);
  EXPECT_EQ(changes.markers.size(), 2U);  // its chunk of places, its chunk of edges
  for (const auto& marker : changes.markers) {
    EXPECT_LE(marker.points.size(), 2 * SceneGraphMarkers::kChunk);
  }
}

TEST(SceneGraphMarkers, ARegionThatComesBackHasItsColourAgain) {
  const scene_graph::SceneGraph graph = makeGraph();
  SceneGraphMarkers markers(MarkerConfig{}, "world");
  TaskNumbers numbers;
  const auto colorOf = [](const MarkerArray& array, int region) {
    const auto color = findMarker(array, "regions", region)->color;
    return std::make_tuple(color.r, color.g, color.b);
  };
  const MarkerArray first = markers.update(graph, numbers);
  EXPECT_NE(colorOf(first, 1), colorOf(first, 2));
  scene_graph::SceneGraph other = graph;
  other.region_edges.clear();
  other.regions = {graph.regions[0]};
  other.regions[0].id = {3};
  const MarkerArray second = markers.update(other, numbers);
  EXPECT_EQ(findMarker(second, "regions", 1)->action, Marker::DELETE);
  const MarkerArray third = markers.update(graph, numbers);
  EXPECT_EQ(colorOf(third, 1), colorOf(first, 1));
  EXPECT_EQ(colorOf(third, 2), colorOf(first, 2));
}

TEST(SceneGraphMarkers, ColoursOfDifferentTasksDiffer) {
  std::set<std::tuple<float, float, float>> colors;
  for (int i = -1; i < 30; ++i) {
    const auto color = computeColor(i, 1.0F);
    for (const float channel : {color.r, color.g, color.b}) {
      EXPECT_GE(channel, 0.0F);
      EXPECT_LE(channel, 1.0F);
    }
    colors.emplace(color.r, color.g, color.b);
  }
  EXPECT_EQ(colors.size(), 31U);
}

mapping::MeshTable::Entry makeBlock(const mapping::GridIndex& block, std::size_t num_triangles) {
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh->colors.assign(3, {255, 0, 51});
  mesh->triangles.assign(num_triangles, {0, 1, 2});
  return {block, mapping::StoredMesh(mesh)};
}

std::vector<visualization_msgs::MarkerArray> makeAll(MeshMarkers& markers,
                                                     const std::vector<mapping::GridIndex>& chunks,
                                                     const mapping::MeshTable& meshes) {
  std::vector<visualization_msgs::MarkerArray> messages;
  for (std::size_t next = 0; next < chunks.size();) {
    messages.push_back(markers.makePart(chunks, next, meshes));
  }
  return messages;
}

TEST(MeshMarkers, ChunksHaveIdsThatNeverChange) {
  MeshMarkers markers("world");
  auto meshes = mapping::MeshTable().with(
      {makeBlock({0, 0, 0}, 1), makeBlock({3, 3, 3}, 1), makeBlock({-1, 0, 0}, 1)});
  const auto first = makeAll(markers, {{0, 0, 0}, {-1, 0, 0}}, meshes);
  ASSERT_EQ(first.size(), 1U);
  ASSERT_EQ(first[0].markers.size(), 2U);  // two blocks share a chunk
  EXPECT_EQ(first[0].markers[0].points.size(), 6U);
  EXPECT_EQ(first[0].markers[1].points.size(), 3U);
  meshes = meshes.with({makeBlock({-2, 1, 1}, 5)});
  const auto second = makeAll(markers, {{-1, 0, 0}}, meshes);
  ASSERT_EQ(second[0].markers.size(), 1U);
  EXPECT_EQ(second[0].markers[0].id, 1);
  EXPECT_EQ(second[0].markers[0].points.size(), 18U);
  EXPECT_FLOAT_EQ(second[0].markers[0].colors[0].b, 0.2F);
}

TEST(MeshMarkers, AChunkWithoutAMeshIsDeletedIfItWasEverSent) {
  MeshMarkers markers("world");
  const auto meshes = mapping::MeshTable().with({makeBlock({0, 0, 0}, 1)});
  makeAll(markers, meshes.chunks(), meshes);
  const auto messages = makeAll(markers, {{0, 0, 0}, {7, 7, 7}}, {});
  ASSERT_EQ(messages.size(), 1U);
  ASSERT_EQ(messages[0].markers.size(), 1U);
  EXPECT_EQ(messages[0].markers[0].action, Marker::DELETE);
  EXPECT_EQ(messages[0].markers[0].id, 0);
}

TEST(MeshMarkers, AClearedMapDeletesAll) {
  MeshMarkers markers("world");
  const auto meshes = mapping::MeshTable().with({makeBlock({0, 0, 0}, 1)});
  makeAll(markers, meshes.chunks(), meshes);
  const auto message = markers.clear();
  ASSERT_EQ(message.markers.size(), 1U);
  EXPECT_EQ(message.markers[0].action, Marker::DELETEALL);
  EXPECT_EQ(message.markers[0].header.frame_id, "world");
}

TEST(MeshMarkers, MessagesAreOfBoundedSize) {
  MeshMarkers markers("world");
  std::vector<mapping::MeshTable::Entry> blocks;
  for (int i = 0; i < 10; ++i) blocks.push_back(makeBlock({4 * i, 0, 0}, 3000));
  const auto meshes = mapping::MeshTable().with(blocks);
  const auto messages = makeAll(markers, meshes.chunks(), meshes);
  std::size_t num_markers = 0;
  for (const auto& message : messages) {
    std::size_t num_vertices = 0;
    for (const auto& marker : message.markers) num_vertices += marker.points.size();
    EXPECT_LE(num_vertices, MeshMarkers::kMaxVertices);
    num_markers += message.markers.size();
  }
  EXPECT_EQ(num_markers, 10U);
  EXPECT_EQ(messages.size(), 5U);
}

TEST(FrameMatcher, EitherMayComeFirstAndOnlyEqualStampsMeet) {
  FrameMatcher matcher(10);
  const auto frame = [](double s) {
    auto made = std::make_shared<RgbdFrame>();
    made->stamp = Stamp::fromSeconds(s);
    return made;
  };
  const auto segmentation = [](double s) {
    auto made = std::make_shared<Segmentation>();
    made->stamp = Stamp::fromSeconds(s);
    return made;
  };
  EXPECT_FALSE(matcher.addFrame(frame(1.0)));
  EXPECT_FALSE(matcher.addFrame(frame(2.0)));
  EXPECT_FALSE(matcher.addSegmentation(segmentation(1.5)));
  const auto late = matcher.addSegmentation(segmentation(2.0));
  ASSERT_TRUE(late);
  EXPECT_EQ(late->frame->stamp, late->segmentation->stamp);
  EXPECT_EQ(matcher.numFrames(), 0U);  // the older frame can meet nothing any more
  EXPECT_EQ(matcher.numUnmatchedSegmentations(), 1U);
  EXPECT_FALSE(matcher.addSegmentation(segmentation(3.0)));
  EXPECT_TRUE(matcher.addFrame(frame(3.0)));
}

TEST(FrameMatcher, AnEpochsSegmentationsMeetItsOwnFramesOnly) {
  FrameMatcher matcher(10);
  const auto frame = [](double s) {
    auto made = std::make_shared<RgbdFrame>();
    made->stamp = Stamp::fromSeconds(s);
    return made;
  };
  const auto segmentation = [](double s) {
    auto made = std::make_shared<Segmentation>();
    made->stamp = Stamp::fromSeconds(s);
    return made;
  };
  EXPECT_FALSE(matcher.addFrame(frame(9.0)));
  EXPECT_FALSE(matcher.addSegmentation(segmentation(1.0), 2));  // the jump is not noticed here yet
  EXPECT_FALSE(matcher.addFrame(frame(10.0)));
  matcher.startEpoch(2);
  EXPECT_EQ(matcher.numFrames(), 0U);
  EXPECT_FALSE(matcher.addSegmentation(segmentation(10.0), 1));  // late, of the epoch before
  EXPECT_TRUE(matcher.addFrame(frame(1.0)));
  EXPECT_FALSE(matcher.addFrame(frame(10.0)));
  EXPECT_EQ(matcher.numUnmatchedSegmentations(), 1U);
  EXPECT_TRUE(matcher.addSegmentation(segmentation(10.0), 2));
}

TEST(FrameMatcher, KeepsABoundedNumberOfFrames) {
  FrameMatcher matcher(3);
  for (int i = 0; i < 10; ++i) {
    auto frame = std::make_shared<RgbdFrame>();
    frame->stamp = Stamp::fromSeconds(i);
    matcher.addFrame(frame);
  }
  EXPECT_EQ(matcher.numFrames(), 3U);
}

TEST(DynamicReconfigure, DefaultsAndRangesAreThoseOfTheStruct) {
  const scene_graph::SceneGraphConfig expected;
  const auto& defaults = ::task_scene_graph::SceneGraphTuningConfig::__getDefault__();
  EXPECT_EQ(defaults.object_alpha, expected.object_alpha);
  EXPECT_EQ(defaults.object_delta, expected.object_delta);
  EXPECT_EQ(defaults.object_top_k, expected.object_top_k);
  EXPECT_EQ(defaults.object_delta_bits, expected.object_delta_bits);
  EXPECT_EQ(defaults.place_alpha, expected.place_alpha);
  EXPECT_EQ(defaults.place_delta, expected.place_delta);
  EXPECT_EQ(defaults.place_top_k, expected.place_top_k);
  EXPECT_EQ(defaults.place_delta_bits, expected.place_delta_bits);
  EXPECT_EQ(defaults.place_smoothing_per_m, expected.place_smoothing_per_m);
  EXPECT_EQ(defaults.min_region_places, expected.min_region_places);
  EXPECT_EQ(defaults.prune_null, expected.prune_null);
  EXPECT_EQ(defaults.min_object_score, expected.min_object_score);
  const MarkerConfig markers;
  EXPECT_EQ(defaults.markers_object_lift_m, markers.object_lift_m);
  EXPECT_EQ(defaults.markers_place_lift_m, markers.place_lift_m);
  EXPECT_EQ(defaults.markers_region_lift_m, markers.region_lift_m);
  EXPECT_EQ(defaults.markers_text_height_m, markers.text_height_m);
  EXPECT_EQ(defaults.markers_label_distance_m, markers.label_distance_m);
  std::map<std::string, std::string> ranges;
  for (const auto& row : config::describe<scene_graph::SceneGraphConfig>()) {
    ranges[row.name] = row.range;
  }
  for (const auto& row : config::describe<MarkerConfig>()) {
    ranges["markers_" + row.name] = row.range;
  }
  dynamic_reconfigure::Config lowest, highest;
  ::task_scene_graph::SceneGraphTuningConfig::__getMin__().__toMessage__(lowest);
  ::task_scene_graph::SceneGraphTuningConfig::__getMax__().__toMessage__(highest);
  for (std::size_t i = 0; i < lowest.doubles.size(); ++i) {
    EXPECT_EQ(ranges[lowest.doubles[i].name],
              config::internal::formatRange({lowest.doubles[i].value, highest.doubles[i].value}))
        << lowest.doubles[i].name;
  }
}

}  // namespace
}  // namespace tsg::ros_interface
