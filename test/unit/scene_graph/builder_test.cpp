// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/builder.h"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "random_world.h"
#include "sample_graph.h"
#include "support.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/scene_graph/files.h"

namespace tsg::scene_graph {
namespace {

/// The whole graph as text, to compare two of them.
std::string describe(const SceneGraph& graph) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "graph.json").string();
  writeSparkDsg(path, graph);
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

class RandomGraphs : public ::testing::TestWithParam<unsigned> {
 protected:
  SceneGraphBuilder makeBuilder(const SceneGraphConfig& config = {}) {
    SceneGraphBuilder builder(config);
    builder.setObjectTasks(world_.tasks());
    builder.setPlaceTasks(place_world_.tasks());
    builder.addPrimitives(primitives_);
    builder.setPlaces(places_);
    return builder;
  }

  RandomWorld world_{GetParam()};
  RandomWorld place_world_{GetParam() + 50, 3};
  std::vector<ObjectPrimitivePtr> primitives_ = world_.makePrimitives(80, 8.0, 1);
  PlaceGraphPtr places_ = std::make_shared<PlaceGraph>(place_world_.makePlaces(50));
};
INSTANTIATE_TEST_SUITE_P(Seeds, RandomGraphs, ::testing::Range(1U, 6U));

TEST_P(RandomGraphs, HoldEverythingInOrder) {
  SceneGraphBuilder builder = makeBuilder();
  const SceneGraphPtr graph = builder.snapshot();
  EXPECT_EQ(graph->primitives, primitives_);
  EXPECT_EQ(graph->places, places_);
  EXPECT_EQ(graph->object_tasks, world_.tasks().names);
  EXPECT_EQ(graph->place_tasks, place_world_.tasks().names);
  EXPECT_FALSE(graph->objects.empty());
  EXPECT_FALSE(graph->regions.empty());
  const auto byId = [](const auto& a, const auto& b) { return a.id < b.id; };
  EXPECT_TRUE(std::is_sorted(graph->objects.begin(), graph->objects.end(), byId));
  EXPECT_TRUE(std::is_sorted(graph->regions.begin(), graph->regions.end(), byId));
  for (const auto& object : graph->objects) EXPECT_TRUE(object.id.isValid());
  for (const auto& region : graph->regions) EXPECT_TRUE(region.id.isValid());
  std::int64_t newest_ns = 0;
  for (const auto& p : primitives_) newest_ns = std::max(newest_ns, p->last_seen.ns);
  EXPECT_EQ(graph->stamp.ns, newest_ns);
}

TEST_P(RandomGraphs, PutEachObjectAtItsNearestPlace) {
  const SceneGraphPtr graph = makeBuilder().snapshot();
  for (const auto& object : graph->objects) {
    double chosen_m = -1.0;
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const auto& place : places_->places) {
      const double distance_m = (place.position_m - object.position_m).norm();
      nearest_m = std::min(nearest_m, distance_m);
      if (place.id == object.place) chosen_m = distance_m;
    }
    EXPECT_EQ(chosen_m, nearest_m);
  }
}

TEST_P(RandomGraphs, JoinRegionsOfWhichPlacesAreJoined) {
  const SceneGraphPtr graph = makeBuilder().snapshot();
  std::set<std::pair<RegionId, RegionId>> expected;
  for (const auto& r : graph->regions) {
    for (const auto& s : graph->regions) {
      if (!(r.id < s.id)) continue;
      for (const auto& edge : places_->edges) {
        const auto joins = [&](const Region& x, const Region& y) {
          return std::count(x.places.begin(), x.places.end(), edge.a) == 1 &&
                 std::count(y.places.begin(), y.places.end(), edge.b) == 1;
        };
        if (joins(r, s) || joins(s, r)) expected.emplace(r.id, s.id);
      }
    }
  }
  std::vector<std::pair<RegionId, RegionId>> found;
  for (const auto& edge : graph->region_edges) found.emplace_back(edge.a, edge.b);
  EXPECT_EQ(found, (std::vector<std::pair<RegionId, RegionId>>(expected.begin(), expected.end())));
  EXPECT_FALSE(found.empty());
}

TEST_P(RandomGraphs, KnowTheDoorsAndObjectsOfEveryRegionAndTheWidestPassages) {
  const SceneGraphPtr graph = makeBuilder().snapshot();
  const auto region_of = computeRegionOfPlaces(*graph);
  std::map<PlaceId, RegionId> regions;
  for (std::size_t i = 0; i < region_of.size(); ++i) {
    regions[places_->places[i].id] = region_of[i];
  }
  for (const Region& region : graph->regions) {
    std::set<PlaceId> doors;
    for (const auto& edge : places_->edges) {
      if (!regions[edge.a].isValid() || !regions[edge.b].isValid()) continue;
      if (regions[edge.a] == regions[edge.b]) continue;
      if (regions[edge.a] == region.id) doors.insert(edge.a);
      if (regions[edge.b] == region.id) doors.insert(edge.b);
    }
    EXPECT_EQ(region.doors, std::vector<PlaceId>(doors.begin(), doors.end()));
    std::vector<ObjectId> objects;
    for (const SceneObject& object : graph->objects) {
      if (regions[object.place] == region.id) objects.push_back(object.id);
    }
    EXPECT_EQ(region.objects, objects);
  }
  for (const RegionEdge& joined : graph->region_edges) {
    double widest_m = 0.0;
    for (const auto& edge : places_->edges) {
      if (std::minmax(regions[edge.a], regions[edge.b]) != std::minmax(joined.a, joined.b))
        continue;
      widest_m = std::max(widest_m, edge.clearance_m);
    }
    EXPECT_EQ(joined.passage_m, widest_m);
    EXPECT_GT(joined.merge_loss, 0.0);
    EXPECT_EQ(joined.merge_threshold, graph->config.place_delta_bits);
  }
}

TEST_P(RandomGraphs, KnowTheRegionOfEveryPlaceAndObject) {
  SceneGraphConfig config;
  config.place_smoothing_per_m = 0.0;  // so that places without an embedding are in none
  const SceneGraphPtr graph = makeBuilder(config).snapshot();
  const auto of_places = computeRegionOfPlaces(*graph);
  const auto of_objects = computeRegionOfObjects(*graph);
  ASSERT_EQ(of_places.size(), places_->places.size());
  ASSERT_EQ(of_objects.size(), graph->objects.size());
  std::map<PlaceId, RegionId> expected;
  for (const auto& place : places_->places) expected[place.id] = {};
  for (const auto& region : graph->regions) {
    for (const PlaceId id : region.places) expected.at(id) = region.id;
  }
  for (std::size_t i = 0; i < of_places.size(); ++i) {
    EXPECT_EQ(of_places[i], expected.at(places_->places[i].id));
    EXPECT_EQ(of_places[i].isValid(), places_->places[i].embedding.size() > 0);
  }
  for (std::size_t i = 0; i < of_objects.size(); ++i) {
    EXPECT_EQ(of_objects[i], expected.at(graph->objects[i].place));
  }
}

TEST_P(RandomGraphs, AreTheSameForAnyNumberOfThreads) {
  SceneGraphConfig one;
  SceneGraphConfig four;
  four.num_threads = 4;
  SceneGraph a = *makeBuilder(one).snapshot();
  SceneGraph b = *makeBuilder(four).snapshot();
  b.config = a.config;
  EXPECT_EQ(describe(a), describe(b));
}

TEST_P(RandomGraphs, ReturnToWhatTheyWereWhenTheConfigurationDoes) {
  SceneGraphBuilder builder = makeBuilder();
  const auto members = [](const SceneGraph& graph) {
    std::set<std::vector<PrimitiveId>> groups;
    for (const auto& object : graph.objects) groups.insert(object.primitives);
    return groups;
  };
  const auto before = members(*builder.snapshot());
  SceneGraphConfig config;
  config.object_alpha = 0.6;
  config.object_delta = 0.1;
  builder.setConfig(config);
  EXPECT_NE(members(*builder.snapshot()), before);
  EXPECT_EQ(builder.snapshot()->config.object_alpha, 0.6);
  builder.setConfig({});
  EXPECT_EQ(members(*builder.snapshot()), before);
}

TEST_P(RandomGraphs, AreMadeAnewOnlyIfSomethingChanged) {
  SceneGraphBuilder builder = makeBuilder();
  const SceneGraphPtr graph = builder.snapshot();
  EXPECT_EQ(builder.snapshot(), graph);
  builder.addPrimitives({});
  builder.addPrimitives(primitives_);
  builder.setPlaces(places_);
  builder.setObjectTasks(world_.tasks());
  builder.setPlaceTasks(place_world_.tasks());
  builder.setConfig({});
  EXPECT_EQ(builder.snapshot(), graph);
  builder.addPrimitives(world_.makePrimitives(1, 8.0, 1000));
  const SceneGraphPtr grown = builder.snapshot();
  EXPECT_NE(grown, graph);
  EXPECT_EQ(graph->primitives.size(), 80U);
  EXPECT_EQ(grown->primitives.size(), 81U);
  EXPECT_EQ(builder.primitiveCounters().repeated, 80U);
}

TEST(EmptyGraphs, AreSnapshotsToo) {
  SceneGraphBuilder builder(SceneGraphConfig{});
  SceneGraphPtr graph = builder.snapshot();
  EXPECT_TRUE(graph->objects.empty());
  EXPECT_TRUE(graph->regions.empty());
  ASSERT_NE(graph->places, nullptr);
  EXPECT_TRUE(graph->places->places.empty());
  builder.setPlaces(std::make_shared<PlaceGraph>());
  builder.setObjectTasks({});
  builder.setConfig({});
  EXPECT_TRUE(builder.snapshot()->regions.empty());
}

TEST(EmptyGraphs, ObjectsWithoutPlacesHaveNone) {
  RandomWorld world(3);
  SceneGraphBuilder builder(SceneGraphConfig{});
  builder.setObjectTasks(world.tasks());
  builder.addPrimitives(world.makePrimitives(20, 5.0, 1));
  const SceneGraphPtr graph = builder.snapshot();
  ASSERT_FALSE(graph->objects.empty());
  for (const auto& object : graph->objects) EXPECT_FALSE(object.place.isValid());
  for (const RegionId region : computeRegionOfObjects(*graph)) EXPECT_FALSE(region.isValid());
}

TEST(CosineSummaries, AreOfAllPrimitivesAndPlacesThatHaveAnEmbedding) {
  RandomWorld world(3);
  SceneGraphBuilder builder{SceneGraphConfig{}};
  EXPECT_EQ(builder.summarizeObjectCosines().count, 0U);
  builder.setObjectTasks(world.tasks());
  builder.setPlaceTasks(world.tasks());
  builder.addPrimitives(world.makePrimitives(50, 5.0, 1));
  builder.setPlaces(std::make_shared<PlaceGraph>(world.makePlaces(30)));
  const SceneGraphPtr graph = builder.snapshot();
  const CosineSummary objects = builder.summarizeObjectCosines();
  EXPECT_EQ(objects.count, builder.primitiveCounters().clustered);
  for (const SceneObject& object : graph->objects) {
    const bool is_alone = object.primitives.size() == 1;
    EXPECT_TRUE(!is_alone || object.score <= objects.highest + 1e-9) << object.score;
  }
  EXPECT_GT(objects.highest, objects.median);
  EXPECT_GT(objects.median, objects.lowest);
  std::size_t places = 0;
  for (const Place& place : graph->places->places) places += place.embedding.size() > 0 ? 1 : 0;
  EXPECT_EQ(builder.summarizePlaceCosines().count, places);
}

TEST(EmptyGraphs, WithoutTasksThereAreNoObjects) {
  RandomWorld world(3);
  SceneGraphBuilder builder(SceneGraphConfig{});
  builder.addPrimitives(world.makePrimitives(20, 5.0, 1));
  EXPECT_TRUE(builder.snapshot()->objects.empty());
  EXPECT_EQ(builder.snapshot()->primitives.size(), 20U);
  builder.setObjectTasks(world.tasks());
  EXPECT_FALSE(builder.snapshot()->objects.empty());
}

TEST(Configuration, OutOfRangeIsRefusedAndTheOldStaysInForce) {
  SceneGraphConfig bad;
  bad.object_alpha = 1.5;
  bad.place_top_k = 0;
  try {
    SceneGraphBuilder{bad};
    FAIL() << "accepted alpha 1.5";
  } catch (const config::ConfigError& e) {
    const std::string message = e.what();
    EXPECT_NE(message.find("'object_alpha' is 1.5"), std::string::npos) << message;
    EXPECT_NE(message.find("'place_top_k' is 0"), std::string::npos) << message;
  }
  SceneGraphBuilder builder(SceneGraphConfig{});
  EXPECT_THROW(builder.setConfig(bad), config::ConfigError);
  EXPECT_EQ(builder.config().object_alpha, 0.23);
  EXPECT_EQ(builder.snapshot()->config.object_alpha, 0.23);
}

TEST(Configuration, ReadsBackFromYaml) {
  SceneGraphConfig config;
  config.object_delta = 3e-4;
  config.place_alpha = 0.5;
  config.prior = bottleneck::Prior::kMarginal;
  const auto read = config::load<SceneGraphConfig>(config::toYaml(config), "test");
  EXPECT_EQ(read.object_delta, 3e-4);
  EXPECT_EQ(read.place_alpha, 0.5);
  EXPECT_EQ(read.prior, bottleneck::Prior::kMarginal);
}

TEST(Configuration, PublishesFromAlphaUnlessTold) {
  SceneGraphConfig config;
  config.object_alpha = 0.3;
  EXPECT_EQ(config.publishedFrom(), 0.3);
  config.min_object_score = 0.2;
  EXPECT_EQ(config.publishedFrom(), 0.2);
}

TEST(SceneGraphBuilder, SnapshotsNameTheFrameTheyAreIn) {
  SceneGraphBuilder builder(SceneGraphConfig{}, "map");
  EXPECT_EQ(builder.snapshot()->world_frame, "map");
}

}  // namespace
}  // namespace tsg::scene_graph
