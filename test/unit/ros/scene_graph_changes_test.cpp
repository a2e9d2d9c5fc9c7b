// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/scene_graph_changes.h"

#include <gtest/gtest.h>
#include <ros/serialization.h>

#include <algorithm>
#include <random>
#include <set>
#include <string>

#include "task_scene_graph/ros/image_conversions.h"

namespace tsg::ros_interface {
namespace {

using Status = SceneGraphReader::Status;

std::string bytesOf(const msg::SceneGraph& message) {
  const auto bytes = ::ros::serialization::serializeMessage(message);
  return {reinterpret_cast<const char*>(bytes.buf.get()), bytes.num_bytes};
}

std::uint32_t sizeOf(const msg::SceneGraphChanges& changes) {
  return ::ros::serialization::serializationLength(changes);
}

/// A graph in which things come, go and change at random.
class RandomGraph {
 public:
  explicit RandomGraph(unsigned seed) : random_(seed) {}

  void change() {
    graph.header.stamp.sec += 1;
    if (draw(5) == 0) graph.object_tasks.push_back("task " + std::to_string(draw(9)));
    if (draw(7) == 0) graph.place_tasks.clear();
    changeNodes(graph.objects, [&](auto& object) {
      object.score = static_cast<float>(draw(100));
      object.primitives.resize(draw(4), draw(9));
    });
    changeNodes(graph.places, [&](auto& place) { place.position.x = draw(100); });
    changeNodes(graph.regions, [&](auto& region) {
      region.task = std::to_string(draw(9));
      region.places.resize(draw(5), draw(9));
    });
    changeEdges(graph.place_edges,
                [&](auto& edge) { edge.clearance = static_cast<float>(draw(9)); });
    changeEdges(graph.region_edges,
                [&](auto& edge) { edge.passage = static_cast<float>(draw(9)); });
  }

  std::uint32_t draw(std::uint32_t below) {
    return std::uniform_int_distribution<std::uint32_t>(0, below - 1)(random_);
  }

  msg::SceneGraph graph;

 private:
  template <typename Node, typename Change>
  void changeNodes(std::vector<Node>& nodes, const Change& change) {
    dropSome(nodes);
    for (auto& node : nodes) {
      if (draw(4) == 0) change(node);
    }
    for (std::uint32_t i = draw(3); i > 0; --i) {
      Node node;
      node.id = 1 + draw(40);
      const auto place =
          std::lower_bound(nodes.begin(), nodes.end(), node.id,
                           [](const Node& a, std::uint64_t id) { return a.id < id; });
      if (place != nodes.end() && place->id == node.id) continue;
      change(node);
      nodes.insert(place, node);
    }
  }

  template <typename Edge, typename Change>
  void changeEdges(std::vector<Edge>& edges, const Change& change) {
    dropSome(edges);
    for (auto& edge : edges) {
      if (draw(4) == 0) change(edge);
    }
    for (std::uint32_t i = draw(4); i > 0; --i) {
      Edge edge;
      edge.a = 1 + draw(6);
      edge.b = edge.a + 1 + draw(6);
      const auto isBefore = [](const Edge& x, const Edge& y) {
        return std::make_pair(x.a, x.b) < std::make_pair(y.a, y.b);
      };
      const auto place = std::lower_bound(edges.begin(), edges.end(), edge, isBefore);
      if (place != edges.end() && place->a == edge.a && place->b == edge.b) continue;
      change(edge);
      edges.insert(place, edge);
    }
  }

  template <typename Item>
  void dropSome(std::vector<Item>& items) {
    items.erase(
        std::remove_if(items.begin(), items.end(), [&](const auto&) { return draw(6) == 0; }),
        items.end());
  }

  std::mt19937 random_;
};

TEST(SceneGraphChanges, AppliedOneAfterTheOtherTheyGiveTheWholeGraph) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    RandomGraph world(seed);
    SceneGraphReader reader;
    std::uint64_t sequence = 1;
    ASSERT_EQ(reader.apply(toWholeGraph(world.graph, sequence)), Status::kApplied);
    for (int round = 0; round < 60; ++round) {
      const msg::SceneGraph before = world.graph;
      world.change();
      msg::SceneGraphChanges changes = computeChanges(before, world.graph);
      changes.sequence = ++sequence;
      ASSERT_EQ(reader.apply(changes), Status::kApplied);
      ASSERT_EQ(bytesOf(reader.graph()), bytesOf(world.graph)) << seed << " " << round;
    }
  }
}

TEST(SceneGraphChanges, ALateSubscriberWhoIsSentTheWholeGraphFollowsFromThere) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    RandomGraph world(seed);
    SceneGraphReader reader;
    std::uint64_t sequence = 0;
    const std::uint32_t joins_at = world.draw(20);
    for (std::uint32_t round = 0; round < 30; ++round) {
      const msg::SceneGraph before = world.graph;
      world.change();
      msg::SceneGraphChanges changes = computeChanges(before, world.graph);
      changes.sequence = ++sequence;
      // roscpp may queue the change that the whole graph holds already behind it.
      if (round == joins_at) {
        EXPECT_EQ(reader.apply(toWholeGraph(world.graph, sequence)), Status::kApplied);
        EXPECT_EQ(reader.apply(changes), Status::kKnown);
      } else {
        EXPECT_EQ(reader.apply(changes), round < joins_at ? Status::kWaiting : Status::kApplied);
      }
    }
    EXPECT_EQ(bytesOf(reader.graph()), bytesOf(world.graph));
  }
}

TEST(SceneGraphChanges, ALostMessageIsNoticedAndTheWholeGraphMendsIt) {
  RandomGraph world(3);
  SceneGraphReader reader;
  reader.apply(toWholeGraph(world.graph, 5));
  const auto makeNext = [&](std::uint64_t sequence) {
    const msg::SceneGraph before = world.graph;
    world.change();
    msg::SceneGraphChanges changes = computeChanges(before, world.graph);
    changes.sequence = sequence;
    return changes;
  };
  EXPECT_EQ(reader.apply(makeNext(6)), Status::kApplied);
  makeNext(7);
  EXPECT_EQ(reader.apply(makeNext(8)), Status::kLost);
  EXPECT_FALSE(reader.hasGraph());
  EXPECT_EQ(reader.apply(makeNext(9)), Status::kWaiting);
  EXPECT_EQ(reader.apply(toWholeGraph(world.graph, 9)), Status::kApplied);
  EXPECT_EQ(bytesOf(reader.graph()), bytesOf(world.graph));
  // A stage that started anew counts from 1 again.
  EXPECT_EQ(reader.apply(toWholeGraph({}, 1)), Status::kApplied);
  EXPECT_EQ(reader.sequence(), 1U);
  EXPECT_TRUE(reader.graph().objects.empty());
}

TEST(SceneGraphChanges, WhatIsWrongLeavesTheGraphAsItWas) {
  RandomGraph world(1);
  for (int i = 0; i < 10; ++i) world.change();
  const std::string before = bytesOf(world.graph);
  ASSERT_FALSE(world.graph.objects.empty());
  msg::SceneGraphChanges changes;
  changes.removed_places = {999};
  changes.objects = {world.graph.objects.front()};
  EXPECT_THROW(applyChanges(changes, world.graph), InputError);
  changes.removed_places.clear();
  changes.objects.push_back(changes.objects.front());
  EXPECT_THROW(applyChanges(changes, world.graph), InputError);
  changes.objects.clear();
  changes.removed_place_edges = {1, 2, 3};
  EXPECT_THROW(applyChanges(changes, world.graph), InputError);
  EXPECT_EQ(bytesOf(world.graph), before);
  SceneGraphReader reader;
  reader.apply(toWholeGraph(world.graph, 1));
  changes.sequence = 2;
  EXPECT_EQ(reader.apply(changes), Status::kLost);
  EXPECT_FALSE(reader.hasGraph());
}

TEST(SceneGraphChanges, AreAsLargeAsWhatChanged) {
  msg::SceneGraph graph;
  for (std::uint64_t id = 1; id <= 5000; ++id) {
    graph.places.emplace_back();
    graph.places.back().id = id;
    if (id > 1) {
      graph.place_edges.emplace_back();
      graph.place_edges.back().a = id - 1;
      graph.place_edges.back().b = id;
    }
  }
  msg::SceneGraph after = graph;
  after.places[17].clearance = 1.0F;
  const std::uint32_t empty = sizeOf(computeChanges(graph, graph));
  EXPECT_LT(empty, 100U);
  const std::uint32_t one = sizeOf(computeChanges(graph, after)) - empty;
  for (std::size_t i = 100; i < 200; ++i) after.places[i].clearance = 2.0F;
  EXPECT_EQ(sizeOf(computeChanges(graph, after)) - empty, 101U * one);
}

}  // namespace
}  // namespace tsg::ros_interface
