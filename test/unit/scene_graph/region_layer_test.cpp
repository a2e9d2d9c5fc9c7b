// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/region_layer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
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

/// Places as [Clio24] clusters them: by their own features, all edges, regions of any size.
SceneGraphConfig makePaperConfig() {
  SceneGraphConfig config;
  config.place_top_k = 2;
  config.place_normaliser = bottleneck::Normaliser::kPaper;
  config.place_smoothing_per_m = 0.0;
  config.min_region_places = 1;
  return config;
}

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
  const SceneGraphConfig config = makePaperConfig();
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
      EXPECT_EQ(region.area_m2, same.area_m2);
      EXPECT_EQ(region.footprint_m, same.footprint_m);
    }
    changeSomething(graph_);
  }
}

TEST_P(RandomRegions, AreTouchedOnlyWhereThePlaceGraphChanged) {
  RegionLayer layer(makePaperConfig());
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
  RegionLayer layer(makePaperConfig());
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

/// Graphs share the embeddings that have not changed; those of messages from elsewhere do not.
TEST_P(RandomRegions, AreTheSameWhetherGraphsShareEmbeddingsOrNot) {
  const auto copyEmbeddings = [](PlaceGraph graph) {
    for (Place& place : graph.places) place.embedding = Embedding(*place.embedding);
    return graph;
  };
  RegionLayer sharing{SceneGraphConfig{}};
  RegionLayer reading{SceneGraphConfig{}};
  sharing.setTasks(world_.tasks());
  reading.setTasks(world_.tasks());
  for (int round = 0; round < 12; ++round) {
    const PlaceUpdate shared = sharing.setPlaces(share(graph_));
    const PlaceUpdate read = reading.setPlaces(share(copyEmbeddings(graph_)));
    EXPECT_EQ(shared.updated, read.updated);
    EXPECT_EQ(shared.inserted, read.inserted);
    const auto expected = computeRegions(SceneGraphConfig{}, world_.tasks(), graph_);
    ASSERT_EQ(listMembers(sharing.computeRegions()), listMembers(expected));
    ASSERT_EQ(listMembers(reading.computeRegions()), listMembers(expected));
    changeSomething(graph_);
  }
}

TEST_P(RandomRegions, LieAtThePlaceNearestToTheMean) {
  std::map<PlaceId, Place> places;
  for (const auto& place : graph_.places) places[place.id] = place;
  for (const auto& region : computeRegions(makePaperConfig(), world_.tasks(), graph_)) {
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
  SceneGraphConfig config = makePaperConfig();
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
  SceneGraphConfig config = makePaperConfig();
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
  SceneGraphConfig config = makePaperConfig();
  config.place_delta = 0.0;
  const auto regions = computeRegions(config, world_.tasks(), graph_);
  EXPECT_EQ(regions.size(), findEmbedded(graph_).size());
  for (const auto& region : regions) EXPECT_EQ(region.places.size(), 1U);
}

TEST_P(RandomRegions, HaveNoNameWithAlphaAboveAllScores) {
  SceneGraphConfig config = makePaperConfig();
  config.place_alpha = 1.0;
  for (const auto& region : computeRegions(config, world_.tasks(), graph_)) {
    EXPECT_EQ(region.task_index, -1);
    EXPECT_EQ(region.task, "");
  }
}

/// f_i = (e_i + s sum_j c_ij e_j) / (1 + s sum_j c_ij) over the embeddings that there are.
PlaceGraph smoothByHand(const PlaceGraph& graph, double smoothing_per_m) {
  PlaceGraph smooth = graph;
  for (std::size_t i = 0; i < graph.places.size(); ++i) {
    const PlaceId id = graph.places[i].id;
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(RandomWorld::kSize);
    double total = 0.0;
    for (const Place& other : graph.places) {
      if (other.embedding.size() == 0) continue;
      double weight = other.id == id ? 1.0 : 0.0;
      for (const PlaceEdge& edge : graph.edges) {
        const bool joins =
            (edge.a == id && edge.b == other.id) || (edge.b == id && edge.a == other.id);
        if (joins) weight += smoothing_per_m * edge.clearance_m;
      }
      sum += weight * other.embedding->cast<double>();
      total += weight;
    }
    smooth.places[i].embedding = total > 0.0 ? Embedding((sum / total).cast<float>()) : Embedding();
  }
  return smooth;
}

TEST_P(RandomRegions, OfTheDefaultsAreClustersOfSmoothFeaturesAlongAllEdges) {
  SceneGraphConfig config;
  config.min_region_places = 1;
  EXPECT_EQ(
      listMembers(computeRegions(config, world_.tasks(), graph_)),
      clusterDirectly(config, world_.tasks(), smoothByHand(graph_, config.place_smoothing_per_m)));
}

TEST_P(RandomRegions, OfTheDefaultsAreTheSameAfterManySmallChangesAsFromTheLastGraphAlone) {
  const SceneGraphConfig config;
  RegionLayer layer(config);
  layer.setTasks(world_.tasks());
  for (int round = 0; round < 12; ++round) {
    layer.setPlaces(share(graph_));
    ASSERT_EQ(listMembers(layer.computeRegions()),
              listMembers(computeRegions(config, world_.tasks(), graph_)));
    changeSomething(graph_);
    graph_.edges[world_.drawIndex(graph_.edges.size())].clearance_m *= 3.0;
  }
}

TEST_P(RandomRegions, FollowAChangeOfTasksAndConfiguration) {
  RegionLayer layer(makePaperConfig());
  layer.setPlaces(share(graph_));
  layer.setTasks(world_.tasks());
  SceneGraphConfig config;
  layer.setConfig(config);
  EXPECT_EQ(listMembers(layer.computeRegions()),
            listMembers(computeRegions(config, world_.tasks(), graph_)));
  TaskList fewer = world_.tasks();
  fewer.names.resize(2);
  fewer.embeddings.conservativeResize(2, Eigen::NoChange);
  layer.setTasks(fewer);
  EXPECT_EQ(listMembers(layer.computeRegions()),
            listMembers(computeRegions(config, fewer, graph_)));
}

TEST_P(RandomRegions, OfTheDefaultsHaveNeighboursOnlyIfTheyAreLarge) {
  const SceneGraphConfig config;
  std::map<PlaceId, std::size_t> region_of;
  const auto regions = computeRegions(config, world_.tasks(), graph_);
  for (std::size_t i = 0; i < regions.size(); ++i) {
    for (const PlaceId place : regions[i].places) region_of[place] = i;
  }
  for (const PlaceEdge& edge : graph_.edges) {
    if (region_of.count(edge.a) + region_of.count(edge.b) < 2) continue;
    if (region_of[edge.a] == region_of[edge.b]) continue;
    EXPECT_GE(regions[region_of[edge.a]].places.size(), 3U);
    EXPECT_GE(regions[region_of[edge.b]].places.size(), 3U);
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
  SceneGraphConfig config = makePaperConfig();
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

/// A row of places, 1 m apart with edges of 1 m, each like the kitchen (0) or the office (1) by a
/// share.
PlaceGraph makeRow(const std::vector<float>& office_shares) {
  PlaceGraph graph;
  for (std::size_t i = 0; i < office_shares.size(); ++i) {
    const float share = office_shares[i];
    graph.places.push_back({{i + 1},
                            {static_cast<double>(i), 0, 0},
                            1.0,
                            makeEmbedding({share, 1.0F - share, 0.1F}),
                            1});
    if (i > 0) graph.edges.push_back({{i}, {i + 1}, 1.0});
  }
  return graph;
}

TEST(Regions, DoNotSplitByTheSecondBestTask) {
  TaskList tasks = makePlaceTasks();
  tasks.names.push_back("stairs");
  tasks.embeddings.conservativeResize(3, Eigen::NoChange);
  tasks.embeddings.row(2) << 0.0F, 0.0F, 1.0F;
  PlaceGraph graph = makeRow({0, 0, 0, 0, 0, 0});
  for (Place& place : graph.places) {  // the second is office or stairs in turn
    const bool is_odd = place.id.value % 2 == 1;
    place.embedding = makeEmbedding({is_odd ? 0.5F : 0.3F, 1.0F, is_odd ? 0.3F : 0.5F});
  }
  SceneGraphConfig config;
  config.place_smoothing_per_m = 0.0;
  EXPECT_EQ(computeRegions(config, tasks, graph).size(), 1U);
  config.place_top_k = 2;
  config.min_region_places = 1;
  config.place_delta_bits = 0.1;
  EXPECT_EQ(computeRegions(config, tasks, graph).size(), 6U);
}

TEST(Regions, SmoothAwayAPlaceThatDiffersFromItsSurroundings) {
  const PlaceGraph graph = makeRow({0.1F, 0.2F, 0.1F, 0.6F, 0.1F, 0.2F, 0.1F});
  SceneGraphConfig config;
  config.min_region_places = 1;
  EXPECT_EQ(computeRegions(config, makePlaceTasks(), graph).size(), 1U);
  config.place_smoothing_per_m = 0.0;
  EXPECT_EQ(computeRegions(config, makePlaceTasks(), graph).size(), 3U);
}

TEST(Regions, EndAtANarrowPassageRatherThanBeyondIt) {
  PlaceGraph graph = makeRow({0.1F, 0.1F, 0.1F, 0.52F, 0.9F, 0.9F, 0.9F});
  graph.edges[3].clearance_m = 0.1;  // between places 4 and 5: the door
  const auto regions = computeRegions(SceneGraphConfig{}, makePlaceTasks(), graph);
  ASSERT_EQ(regions.size(), 2U);
  EXPECT_EQ(regions[0].places, (Ids{{1}, {2}, {3}, {4}}));
}

TEST(Regions, TakeInPlacesThatNoViewSaw) {
  PlaceGraph graph = makeRow({0.1F, 0.1F, 0.1F});
  graph.places[1].embedding = Embedding();
  RegionLayer layer(SceneGraphConfig{});
  layer.setTasks(makePlaceTasks());
  EXPECT_EQ(layer.setPlaces(share(graph)).without_embedding, 0U);
  EXPECT_EQ(listMembers(layer.computeRegions()), (std::vector<Ids>{{{1}, {2}, {3}}}));
}

/// Two rooms of 4 x 4 places, joined by a door.
PlaceGraph makeTwoRooms() {
  PlaceGraph graph;
  for (std::uint64_t i = 0; i < 32; ++i) {
    const double x = static_cast<double>(i % 4) + (i < 16 ? 0.0 : 4.0);
    graph.places.push_back({{i + 1}, {x, static_cast<double>(i / 4 % 4), 0}, 1.0, {}, 0});
    if (i % 4 != 3) graph.edges.push_back({{i + 1}, {i + 2}, 0.9});
    if (i == 7) graph.edges.push_back({{8}, {21}, 0.6});
    if (i % 16 < 12) graph.edges.push_back({{i + 1}, {i + 5}, 1.0});
  }
  return graph;
}

TEST(RegionEdges, SayWhatJoiningTheTwoWouldLose) {
  const PlaceGraph graph = makeRow({0.1F, 0.1F, 0.1F, 0.1F, 0.9F, 0.9F, 0.9F});
  RegionLayer layer(SceneGraphConfig{});
  layer.setTasks(makePlaceTasks());
  layer.setPlaces(share(graph));
  const auto clusters = layer.computeClusters();
  ASSERT_EQ(clusters.size(), 2U);
  std::vector<RegionEdge> edges{{clusters[0].id, clusters[1].id}};
  layer.setMergeLosses(clusters, edges);
  // D of 4 and 3 places that share no task, in bits: 4 log2(7/4) + 3 log2(7/3).
  const double cost_bits = 4.0 * std::log2(7.0 / 4.0) + 3.0 * std::log2(7.0 / 3.0);
  EXPECT_NEAR(edges[0].merge_loss, cost_bits / 2.0, 1e-9);
  EXPECT_EQ(edges[0].merge_threshold, 0.5);
}

TEST(RegionEdges, OfThePapersClusteringCompareSharesOfTheInformation) {
  const PlaceGraph graph = makeRow({0.1F, 0.1F, 0.1F, 0.1F, 0.9F, 0.9F, 0.9F});
  SceneGraphConfig config = makePaperConfig();
  config.place_top_k = 1;
  config.place_delta = 0.2;
  RegionLayer layer(config);
  layer.setTasks(makePlaceTasks());
  layer.setPlaces(share(graph));
  const auto clusters = layer.computeClusters();
  ASSERT_EQ(clusters.size(), 2U);
  std::vector<RegionEdge> edges{{clusters[0].id, clusters[1].id}};
  layer.setMergeLosses(clusters, edges);
  const double cost_bits = 4.0 * std::log2(7.0 / 4.0) + 3.0 * std::log2(7.0 / 3.0);
  // One-hot p(y|x) and the uniform prior over two tasks and the null task: I = log2 3.
  EXPECT_NEAR(edges[0].merge_loss, cost_bits / (7.0 * std::log2(3.0)), 1e-9);
  EXPECT_EQ(edges[0].merge_threshold, 0.2);
}

TEST(RegionExplanations, OfPlacesNameTheTasksThatKeepThemApart) {
  RegionLayer layer(SceneGraphConfig{});
  layer.setTasks(makePlaceTasks());
  layer.setPlaces(share(makeRow({0.1F, 0.1F, 0.1F, 0.1F, 0.9F, 0.9F, 0.9F})));
  EXPECT_EQ(
      layer.explainPair({1}, {7}),
      "places 1 and 7 are apart: one serves 'kitchen', the other 'office'; to merge places that "
      "share no task loses at least 1 bit (place_delta_bits)");
  EXPECT_EQ(layer.explainPair({1}, {2}).find("places 1 and 2 are in one region; joined by"), 0U);
  EXPECT_THROW(layer.explainPair({1}, {8}), std::invalid_argument);
}

TEST(RegionExplanations, OfRegionsTellOfSmallPartsThatJoinedThem) {
  SceneGraphConfig config;
  config.place_smoothing_per_m = 0.0;
  RegionLayer layer(config);
  layer.setTasks(makePlaceTasks());
  layer.setPlaces(share(makeRow({0.1F, 0.1F, 0.1F, 0.1F, 0.9F})));
  const auto regions = layer.computeClusters();
  ASSERT_EQ(regions.size(), 1U);
  const std::string text = layer.explainRegion(regions[0].id);
  EXPECT_EQ(text.find("region 1 serves 'kitchen': 4 places in 3 merges"), 0U) << text;
  EXPECT_NE(text.find("small parts beside it joined it (min_region_places): 1 of 5 places"),
            std::string::npos)
      << text;
  EXPECT_NE(layer.explainPair({1}, {5}).find("joined its neighbour"), std::string::npos);
  EXPECT_THROW(layer.explainRegion({99}), std::invalid_argument);
}

TEST(GeometricRegions, NeedNoEmbeddingsNorTasks) {
  SceneGraphConfig config;
  config.region_method = RegionMethod::kGeometric;
  const auto regions = computeRegions(config, {}, makeTwoRooms());
  ASSERT_EQ(regions.size(), 2U);
  EXPECT_EQ(regions[0].places.size(), 16U);
  EXPECT_EQ(regions[0].task_index, -1);
  EXPECT_EQ(regions[0].embedding.size(), 0);
}

TEST(GeometricRegions, AreNamedByTheirPlacesFeaturesAndKeepTheirIds) {
  SceneGraphConfig config;
  config.region_method = RegionMethod::kGeometric;
  RegionLayer layer(config);
  layer.setTasks(makePlaceTasks());
  PlaceGraph graph = makeTwoRooms();
  graph.places[20].embedding = makeEmbedding({1, 0, 0});
  graph.places[3].embedding = makeEmbedding({0, 1, 0});
  layer.setPlaces(share(graph));
  const auto before = layer.computeRegions();
  ASSERT_EQ(before.size(), 2U);
  EXPECT_EQ(before[0].task, "kitchen");
  EXPECT_EQ(before[1].task, "office");
  graph.places.erase(graph.places.begin());  // the first room's smallest place
  graph.edges.erase(std::remove_if(graph.edges.begin(), graph.edges.end(),
                                   [](const PlaceEdge& edge) { return edge.a == PlaceId{1}; }),
                    graph.edges.end());
  layer.setPlaces(share(graph));
  const auto after = layer.computeRegions();
  ASSERT_EQ(after.size(), 2U);
  EXPECT_EQ(after[0].id, before[0].id);
  EXPECT_EQ(after[0].places.front(), PlaceId{2});
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
  graph.places[2].embedding = makeEmbedding({std::numeric_limits<float>::quiet_NaN(), 0, 0});
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
  RegionLayer layer(makePaperConfig());
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
