// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/region_layer.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <set>

#include "random_world.h"
#include "sample_graph.h"
#include "task_scene_graph/bottleneck/clustering.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/scene_graph/scoring.h"

namespace tsg::scene_graph {
namespace {

using Ids = std::vector<PlaceId>;
using Keys = std::pair<std::uint64_t, std::uint64_t>;

PlaceGraphPtr share(const PlaceGraph& graph) { return std::make_shared<PlaceGraph>(graph); }

std::vector<Ids> listMembers(const std::vector<Region>& regions) {
  std::vector<Ids> members;
  for (const auto& region : regions) members.push_back(region.places);
  std::sort(members.begin(), members.end());
  return members;
}

std::vector<Region> computeRegions(const SceneGraphConfig& config, const TaskList& tasks,
                                   const PlaceGraph& graph) {
  RegionLayer layer(config);
  layer.setTasks(tasks);
  layer.setPlaces(share(graph));
  return layer.computeRegions();
}

std::map<std::uint64_t, Embedding> findEmbedded(const PlaceGraph& graph) {
  std::map<std::uint64_t, Embedding> embedded;
  for (const auto& place : graph.places) {
    if (place.embedding.size() > 0) embedded[place.id.value] = place.embedding;
  }
  return embedded;
}

std::set<Keys> findEmbeddedEdges(const PlaceGraph& graph) {
  const auto embedded = findEmbedded(graph);
  std::set<Keys> edges;
  for (const auto& edge : graph.edges) {
    if (embedded.count(edge.a.value) + embedded.count(edge.b.value) == 2) {
      edges.emplace(edge.a.value, edge.b.value);
    }
  }
  return edges;
}

/// The clusters of a batch run over the places with embeddings.
std::vector<Ids> clusterDirectly(const SceneGraphConfig& config, const TaskList& tasks,
                                 const PlaceGraph& graph) {
  using bottleneck::IncrementalClustering;
  IncrementalClustering clustering(config.placeClustering(),
                                   IncrementalClustering::Adjacency::kGiven);
  clustering.setTasks(tasks.embeddings);
  for (const auto& [key, embedding] : findEmbedded(graph)) clustering.insert(key, embedding);
  for (const auto& [a, b] : findEmbeddedEdges(graph)) clustering.insertEdge(a, b);
  std::vector<Ids> regions;
  for (const auto& cluster : clustering.clusters()) {
    regions.emplace_back();
    for (const auto key : cluster.members) regions.back().push_back({key});
  }
  std::sort(regions.begin(), regions.end());
  return regions;
}

class RandomRegions : public ::testing::TestWithParam<unsigned> {
 protected:
  /// Removes, adds, moves and sees places again, and changes edges.
  void changeSomething(PlaceGraph& graph) {
    for (int i = 0; i < 4; ++i) world_.removePlace(graph, world_.drawIndex(graph.places.size()));
    for (int i = 0; i < 3; ++i) {
      graph.places.push_back(world_.makePlace(graph.places.back().id.value + 1));
    }
    for (int i = 0; i < 3; ++i) {
      Place& seen = graph.places[world_.drawIndex(graph.places.size())];
      seen.embedding = world_.draw(0, 1) < 0.2 ? Embedding() : world_.makeEmbedding(1.0F);
      graph.places[world_.drawIndex(graph.places.size())].position_m.x() += 0.5;
    }
    graph.edges.erase(graph.edges.begin() +
                      static_cast<std::ptrdiff_t>(world_.drawIndex(graph.edges.size())));
    for (int i = 0; i < 8; ++i) world_.addRandomEdge(graph);
  }

  RandomWorld world_{GetParam()};
  PlaceGraph graph_ = world_.makePlaces(60);
};
INSTANTIATE_TEST_SUITE_P(Seeds, RandomRegions, ::testing::Range(1U, 9U));

TEST_P(RandomRegions, AreTheSameAfterManySmallChangesAsFromTheLastGraphAlone) {
  const SceneGraphConfig config;
  RegionLayer layer(config);
  layer.setTasks(world_.tasks());
  for (int round = 0; round < 12; ++round) {
    layer.setPlaces(share(graph_));
    const auto incremental = layer.computeRegions();
    ASSERT_EQ(listMembers(incremental), clusterDirectly(config, world_.tasks(), graph_));
    std::map<Ids, Region> batch;
    for (auto& region : computeRegions(config, world_.tasks(), graph_))
      batch[region.places] = region;
    for (const auto& region : incremental) {
      const Region& same = batch.at(region.places);
      EXPECT_EQ(region.position_m, same.position_m);
      EXPECT_EQ(region.embedding, same.embedding);
      EXPECT_EQ(region.task, same.task);
      EXPECT_EQ(region.score, same.score);
    }
    changeSomething(graph_);
  }
}

TEST_P(RandomRegions, AreTouchedOnlyWhereThePlaceGraphChanged) {
  RegionLayer layer(SceneGraphConfig{});
  layer.setTasks(world_.tasks());
  PlaceGraph before;
  for (int round = 0; round < 8; ++round) {
    const PlaceUpdate update = layer.setPlaces(share(graph_));
    PlaceUpdate expected;
    const auto old = findEmbedded(before);
    const auto now = findEmbedded(graph_);
    for (const auto& [key, embedding] : now) {
      expected.inserted += old.count(key) == 0 ? 1 : 0;
      expected.updated += old.count(key) == 1 && old.at(key) != embedding ? 1 : 0;
    }
    for (const auto& entry : old) expected.erased += now.count(entry.first) == 0 ? 1 : 0;
    const auto old_edges = findEmbeddedEdges(before);
    const auto new_edges = findEmbeddedEdges(graph_);
    for (const auto& edge : new_edges) expected.edges_inserted += 1 - old_edges.count(edge);
    for (const auto& edge : old_edges) expected.edges_erased += 1 - new_edges.count(edge);
    EXPECT_EQ(update.inserted, expected.inserted);
    EXPECT_EQ(update.updated, expected.updated);
    EXPECT_EQ(update.erased, expected.erased);
    EXPECT_EQ(update.edges_inserted, expected.edges_inserted);
    EXPECT_EQ(update.edges_erased, expected.edges_erased);
    EXPECT_EQ(update.without_embedding, graph_.places.size() - now.size());
    before = graph_;
    changeSomething(graph_);
  }
}

TEST_P(RandomRegions, StayUntouchedByACopyOfTheSameGraph) {
  RegionLayer layer(SceneGraphConfig{});
  layer.setTasks(world_.tasks());
  layer.setPlaces(share(graph_));
  const auto regions = layer.computeRegions();
  const PlaceUpdate update = layer.setPlaces(share(graph_));
  EXPECT_EQ(update.inserted + update.updated + update.erased, 0U);
  EXPECT_EQ(update.edges_inserted + update.edges_erased, 0U);
  const auto again = layer.computeRegions();
  ASSERT_EQ(again.size(), regions.size());
  for (std::size_t i = 0; i < regions.size(); ++i) {
    EXPECT_EQ(again[i].id, regions[i].id);
    EXPECT_EQ(again[i].places, regions[i].places);
  }
}

TEST_P(RandomRegions, LieAtThePlaceNearestToTheMean) {
  std::map<PlaceId, Place> places;
  for (const auto& place : graph_.places) places[place.id] = place;
  for (const auto& region : computeRegions({}, world_.tasks(), graph_)) {
    Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
    for (const PlaceId id : region.places) mean_m += places.at(id).position_m;
    mean_m /= static_cast<double>(region.places.size());
    bool is_at_a_place = false;
    const double distance_m = (region.position_m - mean_m).norm();
    for (const PlaceId id : region.places) {
      is_at_a_place |= places.at(id).position_m == region.position_m;
      EXPECT_LE(distance_m, (places.at(id).position_m - mean_m).norm() + 1e-9);
    }
    EXPECT_TRUE(is_at_a_place);
  }
}

TEST_P(RandomRegions, AreNamedByTheBestTaskOfTheirMeanIfItReachesAlpha) {
  const auto embedded = findEmbedded(graph_);
  const bottleneck::TaskScorer scorer(world_.tasks().embeddings);
  SceneGraphConfig config;
  config.place_alpha = 0.4;
  int named = 0;
  int unnamed = 0;
  for (const auto& region : computeRegions(config, world_.tasks(), graph_)) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(RandomWorld::kSize);
    for (const PlaceId id : region.places) sum += embedded.at(id.value).cast<double>();
    const Embedding mean = (sum / static_cast<double>(region.places.size())).cast<float>();
    const TaskScore best = findBestTask(mean, scorer);
    EXPECT_NEAR(region.score, best.cosine, 1e-6);
    const bool is_named = best.cosine >= config.place_alpha;
    EXPECT_EQ(region.task_index, is_named ? best.task_index : -1);
    EXPECT_EQ(region.task,
              is_named ? world_.tasks().names.at(static_cast<std::size_t>(best.task_index)) : "");
    ++(is_named ? named : unnamed);
  }
  EXPECT_GT(named, 0);
  EXPECT_GT(unnamed, 0);
}

TEST_P(RandomRegions, AreComponentsOfEmbeddedPlacesForDeltaOne) {
  SceneGraphConfig config;
  config.place_delta = 1.0;
  const auto embedded = findEmbedded(graph_);
  Ids ids;
  for (const auto& entry : embedded) ids.push_back({entry.first});
  const auto edges = findEmbeddedEdges(graph_);
  std::vector<Ids> expected;
  for (const auto& group : findComponents(ids.size(), [&](std::size_t i, std::size_t j) {
         return edges.count(std::minmax(ids[i].value, ids[j].value)) == 1;
       })) {
    expected.emplace_back();
    for (const std::size_t i : group) expected.back().push_back(ids[i]);
  }
  EXPECT_EQ(listMembers(computeRegions(config, world_.tasks(), graph_)), expected);
}

TEST_P(RandomRegions, AreSinglePlacesForDeltaZero) {
  SceneGraphConfig config;
  config.place_delta = 0.0;
  const auto regions = computeRegions(config, world_.tasks(), graph_);
  EXPECT_EQ(regions.size(), findEmbedded(graph_).size());
  for (const auto& region : regions) EXPECT_EQ(region.places.size(), 1U);
}

TEST_P(RandomRegions, HaveNoNameWithAlphaAboveAllScores) {
  SceneGraphConfig config;
  config.place_alpha = 1.0;
  for (const auto& region : computeRegions(config, world_.tasks(), graph_)) {
    EXPECT_EQ(region.task_index, -1);
    EXPECT_EQ(region.task, "");
  }
}

TaskList makePlaceTasks() {
  TaskList tasks;
  tasks.names = {"kitchen", "office"};
  tasks.embeddings.resize(2, 3);
  tasks.embeddings << 0.0F, 1.0F, 0.0F, 1.0F, 0.0F, 0.0F;
  return tasks;
}

/// Merges the two kitchen places of makePlaces(): of few places, each holds much of what is known.
SceneGraphConfig makeCoarseConfig() {
  SceneGraphConfig config;
  config.place_delta = 0.2;
  return config;
}

TEST(Regions, SplitWhereThePlacesServeOtherTasks) {
  RegionLayer layer(makeCoarseConfig());
  layer.setTasks(makePlaceTasks());
  const PlaceUpdate update = layer.setPlaces(makePlaces());
  EXPECT_EQ(update.inserted, 3U);
  EXPECT_EQ(update.without_embedding, 1U);
  EXPECT_EQ(update.edges_inserted, 2U);
  const auto regions = layer.computeRegions();
  ASSERT_EQ(regions.size(), 2U);
  EXPECT_EQ(regions[0].task, "kitchen");
  EXPECT_EQ(regions[0].places, (Ids{{1}, {2}}));
  EXPECT_EQ(regions[1].task, "office");
  EXPECT_EQ(regions[1].places, (Ids{{4}}));
}

TEST(Regions, KeepTheirIdsWhenAPlaceComesOrGoes) {
  RegionLayer layer(makeCoarseConfig());
  layer.setTasks(makePlaceTasks());
  layer.setPlaces(makePlaces());
  const auto before = layer.computeRegions();
  PlaceGraph grown = *makePlaces();
  grown.places.push_back({{8}, {0, 1, 1}, 1.0, makeEmbedding({0, 1, 0}), 1});
  grown.edges.insert(grown.edges.begin() + 1, {{1}, {8}, 0.5});
  layer.setPlaces(share(grown));
  const auto after = layer.computeRegions();
  ASSERT_EQ(after.size(), 2U);
  EXPECT_EQ(after[0].id, before[0].id);
  EXPECT_EQ(after[0].places, (Ids{{1}, {2}, {8}}));
  EXPECT_EQ(after[1].id, before[1].id);
}

TEST(Regions, WithoutTasksAreTheConnectedPlacesUnnamed) {
  RegionLayer layer(makeCoarseConfig());
  layer.setPlaces(makePlaces());
  for (const auto& region : layer.computeRegions()) EXPECT_EQ(region.task_index, -1);
  EXPECT_FALSE(layer.computeRegions().empty());
}

TEST(Places, OfAnotherEmbeddingSizeAreInNoRegionNamingBothSizes) {
  RegionLayer layer(makeCoarseConfig());
  layer.setTasks(makePlaceTasks());
  PlaceGraph graph = *makePlaces();
  graph.places[1].embedding = makeEmbedding({1, 2});
  graph.places[2].embedding[0] = std::numeric_limits<float>::quiet_NaN();
  const PlaceUpdate update = layer.setPlaces(share(graph));
  EXPECT_EQ(update.rejected, 2U);
  EXPECT_EQ(update.inserted, 1U);
  EXPECT_EQ(update.error, "place 2 has an embedding of 2 values, expected 3 finite ones");
  EXPECT_EQ(listMembers(layer.computeRegions()), (std::vector<Ids>{{{1}}}));
}

TEST(Places, WaitForTasksOfTheirSize) {
  RegionLayer layer(makeCoarseConfig());
  TaskList tasks = makePlaceTasks();
  tasks.embeddings = EmbeddingMatrix::Ones(2, 7);
  layer.setTasks(tasks);
  EXPECT_EQ(layer.setPlaces(makePlaces()).rejected, 3U);
  EXPECT_TRUE(layer.computeRegions().empty());
  layer.setTasks(makePlaceTasks());
  EXPECT_EQ(layer.computeRegions().size(), 2U);
  EXPECT_THROW(layer.setTasks(tasks), config::ConfigError);
  EXPECT_EQ(layer.computeRegions().size(), 2U);
}

TEST(Places, MayChangeTheirEmbeddingSizeOnceThoseOfTheOldSizeAreGone) {
  RegionLayer layer(SceneGraphConfig{});
  layer.setPlaces(makePlaces());
  PlaceGraph other = *makePlaces();
  for (Place& place : other.places) place.embedding = makeEmbedding({1, 2, 3, 4});
  const PlaceUpdate mixed = layer.setPlaces(share(other));
  EXPECT_EQ(mixed.rejected, 4U);
  EXPECT_EQ(mixed.erased, 3U);
  EXPECT_TRUE(layer.computeRegions().empty());
  EXPECT_EQ(layer.setPlaces(share(other)).inserted, 4U);
  EXPECT_FALSE(layer.computeRegions().empty());
}

void expectRefused(const PlaceGraph& graph, const std::string& part) {
  RegionLayer layer(makeCoarseConfig());
  layer.setTasks(makePlaceTasks());
  layer.setPlaces(makePlaces());
  try {
    layer.setPlaces(share(graph));
    FAIL() << "accepted a malformed graph";
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
  }
  EXPECT_EQ(layer.places()->places.size(), 4U);
  EXPECT_EQ(layer.computeRegions().size(), 2U);
}

TEST(Places, ThatAreNowhereAreRefusedAndTheOldStay) {
  for (const double odd :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    PlaceGraph graph = *makePlaces();
    graph.places[2].position_m.y() = odd;
    expectRefused(graph, "place 4 has a position or clearance that is not finite");
    graph = *makePlaces();
    graph.places[0].clearance_m = odd;
    expectRefused(graph, "place 1 has a position or clearance that is not finite");
  }
}

TEST(Places, OutOfOrderOrWithLooseEdgesAreRefusedAndTheOldStay) {
  PlaceGraph graph = *makePlaces();
  std::swap(graph.places[0], graph.places[1]);
  expectRefused(graph, "id 1 after 2");
  graph = *makePlaces();
  graph.places[0].id = {};
  expectRefused(graph, "id 0 after 0");
  graph = *makePlaces();
  graph.edges.push_back({{4}, {5}, 1.0});
  expectRefused(graph, "edge 4 - 5");
  graph = *makePlaces();
  graph.edges.push_back({{4}, {2}, 1.0});
  expectRefused(graph, "edge 4 - 2");
  graph = *makePlaces();
  graph.edges.push_back(graph.edges.front());
  expectRefused(graph, "edge 1 - 2");
  RegionLayer layer(makeCoarseConfig());
  EXPECT_THROW(layer.setPlaces(nullptr), std::invalid_argument);
}

}  // namespace
}  // namespace tsg::scene_graph
