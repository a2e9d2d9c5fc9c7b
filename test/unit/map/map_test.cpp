// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/map/map.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "../scene_graph/random_world.h"
#include "support.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/scene_graph/files.h"

namespace tsg::map {
namespace {

using mapping::BlockMesh;
using mapping::GridIndex;
using scene_graph::SceneGraphBuilder;

ObjectPrimitivePtr makePrimitive(std::uint64_t id, double last_seen_s = 1.0) {
  auto primitive = std::make_shared<ObjectPrimitive>();
  primitive->id = {id};
  primitive->box = makeAabb({0, 0, 0}, {1, 1, 1});
  primitive->embedding = Embedding::Unit(3, 0);
  primitive->last_seen = Stamp::fromSeconds(last_seen_s);
  return primitive;
}

std::vector<std::uint64_t> listIds(const Map& map) {
  std::vector<std::uint64_t> ids;
  for (const auto& primitive : map.primitives()) ids.push_back(primitive->id.value);
  return ids;
}

PlaceGraphPtr makePlaces(const std::vector<std::uint64_t>& ids) {
  auto graph = std::make_shared<PlaceGraph>();
  graph->stamp = Stamp::fromSeconds(2.0);
  for (const std::uint64_t id : ids) {
    graph->places.push_back({{id}, {1.0 * static_cast<double>(id), 0, 0}, 1.0, {}, 0});
  }
  return graph;
}

std::shared_ptr<const Mesh> makeTriangle(float x_m) {
  Mesh mesh;
  mesh.vertices = {{x_m, 0, 0}, {x_m + 1, 0, 0}, {x_m, 1, 0}};
  mesh.colors.resize(3);
  mesh.triangles = {{0, 1, 2}};
  return std::make_shared<const Mesh>(mesh);
}

/// What `action` throws, as text; "" if nothing.
template <typename Action>
std::string errorOf(const Action& action) {
  try {
    action();
  } catch (const std::exception& e) {
    return e.what();
  }
  return "";
}

/// A graph as its files have it, with every digit.
std::string toText(const scene_graph::SceneGraph& graph) {
  const test::TemporaryFolder folder;
  std::string text;
  for (const char* name : {"graph.json", "summary.json"}) {
    const std::string path = (folder.path() / name).string();
    if (text.empty()) {
      writeSparkDsg(path, graph);
    } else {
      writeSummary(path, graph);
    }
    std::ostringstream content;
    content << std::ifstream(path).rdbuf();
    text += content.str();
  }
  return text;
}

TEST(Map, AnEmptyMapHasNothingAndNoNulls) {
  const Map map("odom");
  EXPECT_EQ(map.worldFrame(), "odom");
  EXPECT_TRUE(map.isEmpty());
  EXPECT_TRUE(map.primitives().empty());
  ASSERT_NE(map.places(), nullptr);
  ASSERT_NE(map.trajectory(), nullptr);
  EXPECT_EQ(map.findPrimitive({1}), nullptr);
  EXPECT_EQ(map.findPlace({1}), nullptr);
  EXPECT_EQ(map.findMesh({0, 0, 0}), nullptr);
  EXPECT_TRUE(computeSceneGraph(map).objects.empty());
  EXPECT_TRUE(computeMesh(map).isEmpty());
}

TEST(Map, PrimitivesAscendByIdInWhateverOrderTheyCome) {
  Map map;
  map.addPrimitives({makePrimitive(7), makePrimitive(2)});
  map.addPrimitives({makePrimitive(5), makePrimitive(9), makePrimitive(1)});
  EXPECT_EQ(listIds(map), (std::vector<std::uint64_t>{1, 2, 5, 7, 9}));
  EXPECT_EQ(map.findPrimitive({5})->id.value, 5U);
  EXPECT_EQ(map.findPrimitive({6}), nullptr);
  EXPECT_TRUE(map.erasePrimitive({5}));
  EXPECT_FALSE(map.erasePrimitive({5}));
  EXPECT_EQ(listIds(map), (std::vector<std::uint64_t>{1, 2, 7, 9}));
}

TEST(Map, APrimitiveTakesThePlaceOfTheOneOfItsId) {
  Map map;
  map.addPrimitives({makePrimitive(2, 1.0), makePrimitive(3, 1.0), makePrimitive(3, 2.0)});
  EXPECT_EQ(map.findPrimitive({3})->last_seen, Stamp::fromSeconds(2.0));
  map.addPrimitives({makePrimitive(2, 5.0)});
  EXPECT_EQ(listIds(map), (std::vector<std::uint64_t>{2, 3}));
  EXPECT_EQ(map.findPrimitive({2})->last_seen, Stamp::fromSeconds(5.0));
  EXPECT_EQ(map.stamp(), Stamp::fromSeconds(5.0));
}

TEST(Map, WhatCannotBeInAMapIsRefusedAndChangesNothing) {
  Map map;
  map.addPrimitives({makePrimitive(2)});
  EXPECT_NE(errorOf([&] {
              map.addPrimitives({makePrimitive(3), nullptr});
            }).find("null"),
            std::string::npos);
  EXPECT_NE(errorOf([&] {
              map.addPrimitives({makePrimitive(3), makePrimitive(0)});
            }).find("id 0"),
            std::string::npos);
  EXPECT_EQ(listIds(map), std::vector<std::uint64_t>{2});
  EXPECT_THROW(map.setPlaces(nullptr), std::invalid_argument);
  EXPECT_THROW(map.setTrajectory(nullptr), std::invalid_argument);
  EXPECT_THROW(map.setMesh(0.0, {}), std::invalid_argument);
  EXPECT_THROW(map.setMesh(0.05, {{GridIndex(0, 0, 0), nullptr}}), std::invalid_argument);
  const auto mesh = makeTriangle(0);
  EXPECT_THROW(map.setMesh(0.05, {{GridIndex(1, 0, 0), mesh}, {GridIndex(0, 0, 0), mesh}}),
               std::invalid_argument);
  EXPECT_EQ(map.meshVoxelSize(), 0.0);
  scene_graph::TaskList twice;
  twice.names = {"wash", "wash"};
  EXPECT_THROW(map.setTasks(twice, {}), config::ConfigError);
  EXPECT_EQ(map.objectTasks().size(), 0U);
}

TEST(Map, ClustersAreFoundByIdAndRefusedOutOfOrder) {
  Map map;
  map.addPrimitives({makePrimitive(1), makePrimitive(2)});
  map.setPlaces(makePlaces({4, 6}));
  map.setClusters({{{3}, 1, {{1}}}, {{8}, 0, {{2}}}}, {{{5}, {{4}, {6}}}});
  EXPECT_EQ(map.findCluster(ObjectId{8})->primitives, std::vector<PrimitiveId>{{2}});
  EXPECT_EQ(map.findCluster(ObjectId{4}), nullptr);
  EXPECT_EQ(map.findCluster(RegionId{5})->places.size(), 2U);
  EXPECT_EQ(map.findPlace({6})->position_m.x(), 6.0);
  EXPECT_EQ(map.findPlace({5}), nullptr);
  EXPECT_THROW(map.setClusters({{{3}, 1, {{1}}}, {{3}, 1, {{2}}}}, {}), std::invalid_argument);
  EXPECT_THROW(map.setClusters({{{0}, 1, {{1}}}}, {}), std::invalid_argument);
  EXPECT_THROW(map.setClusters({}, {{{1}, {}}}), std::invalid_argument);
  EXPECT_EQ(map.objectClusters().size(), 2U);
}

TEST(Map, ASceneGraphOfMembersThatAreNotThereIsRefusedByName) {
  Map map;
  scene_graph::TaskList tasks;
  tasks.names = {"wash"};
  tasks.embeddings = Embedding::Unit(3, 0).transpose();
  map.setTasks(tasks, tasks);
  map.addPrimitives({makePrimitive(1)});
  map.setClusters({{{1}, 1, {{1}}}}, {});
  EXPECT_EQ(computeSceneGraph(map).objects.size(), 1U);
  map.setClusters({{{1}, 1, {{1}, {2}}}}, {});
  EXPECT_EQ(errorOf([&] { computeSceneGraph(map); }),
            "map: primitive 2 of a cluster is not in the map");
  auto other = std::make_shared<ObjectPrimitive>(*makePrimitive(2));
  other->embedding = Embedding::Unit(4, 0);
  map.addPrimitives({other});
  EXPECT_EQ(errorOf([&] { computeSceneGraph(map); }),
            "map: primitive 2 has an embedding of 4 numbers, expected 3");
  map.setClusters({}, {{{1}, {{9}}}});
  EXPECT_EQ(errorOf([&] { computeSceneGraph(map); }),
            "map: place 9 of a cluster is not in the map");
}

TEST(Map, MeshUpdatesReplaceAndRemoveBlocks) {
  Map map;
  const auto mesh = makeTriangle(0);
  const auto newer = makeTriangle(10);
  const GridIndex a(0, 0, 0), b(1, 0, 0), c(0, 1, 0), d(0, 0, 1);
  map.setMesh(0.05, {{a, mesh}, {b, mesh}, {c, mesh}});
  map.updateMesh({{{b, newer}, {d, newer}}, {c}});
  ASSERT_EQ(map.meshBlocks().size(), 3U);
  EXPECT_EQ(map.findMesh(a), mesh);
  EXPECT_EQ(map.findMesh(b), newer);
  EXPECT_EQ(map.findMesh(c), nullptr);
  EXPECT_EQ(map.findMesh(d), newer);
  EXPECT_EQ(computeMesh(map).triangles.size(), 3U);
  EXPECT_EQ(computeMesh(map).vertices.size(), 6U);  // b and d are welded
}

TEST(Map, ASnapshotDoesNotChangeAndSharesWhatIsLarge) {
  Map map;
  map.addPrimitives({makePrimitive(1), makePrimitive(2)});
  map.setPlaces(makePlaces({1}));
  const GridIndex block(0, 0, 0);
  map.setMesh(0.05, {{block, makeTriangle(0)}});
  map.setClusters({{{1}, 0, {{1}, {2}}}}, {});
  const MapPtr before = map.snapshot();
  EXPECT_EQ(before->primitives(), map.primitives());
  EXPECT_EQ(before->places(), map.places());
  EXPECT_EQ(before->findMesh(block), map.findMesh(block));
  EXPECT_EQ(before->trajectory(), map.trajectory());
  map.erasePrimitive({1});
  map.setPlaces(makePlaces({1, 2}));
  map.updateMesh({{}, {block}});
  map.setClusters({}, {});
  EXPECT_EQ(listIds(*before), (std::vector<std::uint64_t>{1, 2}));
  EXPECT_EQ(before->places()->places.size(), 1U);
  EXPECT_NE(before->findMesh(block), nullptr);
  EXPECT_EQ(before->objectClusters().size(), 1U);
}

TEST(Map, TheSceneGraphOfABuildersMapIsTheBuildersOwn) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    scene_graph::RandomWorld world(seed);
    scene_graph::SceneGraphConfig config;
    config.object_delta = 1e-3;
    SceneGraphBuilder builder(config, "odom");
    builder.setObjectTasks(world.tasks());
    builder.setPlaceTasks(world.tasks());
    PlaceGraph places = world.makePlaces(30);
    for (int step = 0; step < 4; ++step) {
      builder.addPrimitives(
          world.makePrimitives(20, 5.0, 1 + 20 * static_cast<std::uint64_t>(step)));
      world.removePlace(places, 3);
      builder.setPlaces(std::make_shared<const PlaceGraph>(places));
      const Map map = makeMap(builder);
      const auto graph = builder.snapshot();
      EXPECT_GT(graph->objects.size(), 1U);
      EXPECT_GT(graph->regions.size(), 1U);
      EXPECT_GE(map.objectClusters().size(), graph->objects.size());
      EXPECT_EQ(toText(computeSceneGraph(map)), toText(*graph)) << seed << ", step " << step;
    }
    config.object_alpha = 0.5;
    builder.setConfig(config);
    EXPECT_EQ(toText(computeSceneGraph(makeMap(builder))), toText(*builder.snapshot()));
  }
}

}  // namespace
}  // namespace tsg::map
