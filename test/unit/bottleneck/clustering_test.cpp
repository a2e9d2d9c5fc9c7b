// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/bottleneck/clustering.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>

#include "clustering_fixtures.h"
#include "task_scene_graph/config/config.h"

namespace tsg::bottleneck {
namespace {

using test::ReferenceResult;
using test::ReferenceScene;
using test::SceneGenerator;
using test::SceneOptions;

template <typename Action>
std::string messageOf(Action action) {
  try {
    action();
  } catch (const std::exception& e) {
    return e.what();
  }
  return "";
}

void expectEqual(IncrementalClustering& clustering, const ReferenceResult& expected) {
  EXPECT_NEAR(clustering.information(), expected.information, 1e-12);
  const std::vector<Merge> merges = clustering.mergeSequence();
  ASSERT_EQ(merges.size(), expected.merges.size());
  for (std::size_t i = 0; i < merges.size(); ++i) {
    ASSERT_EQ(merges[i].a, expected.merges[i].a) << "merge " << i;
    ASSERT_EQ(merges[i].b, expected.merges[i].b) << "merge " << i;
    EXPECT_NEAR(merges[i].d, expected.merges[i].d, 1e-12);
    EXPECT_NEAR(merges[i].delta, expected.merges[i].delta, 1e-12);
  }
  EXPECT_EQ(partitionOf(clustering), expected.clusters);
}

struct Variant {
  std::string name;
  ClusteringConfig config;
  SceneOptions options;
};

std::vector<Variant> makeVariants() {
  std::vector<Variant> variants(7);
  variants[0].name = "PaperDefaults";
  variants[0].options.duplicate_share = 0.7;
  variants[0].options.mean_degree = 8.0;
  variants[1].name = "CoarserDelta";
  variants[1].config.delta = 0.02;
  variants[2].name = "MarginalPrior";
  variants[2].config.delta = 0.03;
  variants[2].config.prior = Prior::kMarginal;
  variants[3].name = "SizeInvariant";
  variants[3].config.normaliser = Normaliser::kSizeInvariant;
  variants[3].config.delta_bits = 0.4;
  variants[4].name = "AllTasksNoPruning";
  variants[4].config = {0.1, 0.01, 100, false, Prior::kUniform, Normaliser::kPaper, 0.03, false, 2};
  variants[5].name = "MergeEverything";
  variants[5].config.delta = 1.0;
  variants[5].options.duplicate_share = 0.7;
  variants[6].name = "DenseManyTasks";
  variants[6].config.delta = 0.01;
  variants[6].config.top_k = 3;
  variants[6].options.mean_degree = 10.0;
  variants[6].options.num_tasks = 11;
  return variants;
}

class ClusteringVariants : public testing::TestWithParam<Variant> {};

TEST_P(ClusteringVariants, BatchEqualsTheDenseReference) {
  std::size_t num_merges = 0;
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    const ReferenceScene scene = SceneGenerator(GetParam().options, seed).makeScene();
    IncrementalClustering clustering = makeClustering(scene, GetParam().config);
    const ReferenceResult expected =
        test::clusterDense(scene, test::findOverlaps(scene), GetParam().config);
    expectEqual(clustering, expected);
    num_merges += expected.merges.size();
  }
  EXPECT_GE(num_merges, 20u) << "the scenes should give something to merge";
}

// One random insertion, update or erasure.
void change(SceneGenerator& generator, ReferenceScene& scene, IncrementalClustering& clustering) {
  const int action = generator.uniformInt(0, 3);
  if (action <= 1 || scene.primitives.size() < 3) {
    const auto key = static_cast<NodeKey>(generator.uniformInt(1, 1000000));
    const auto [place, is_new] = scene.primitives.emplace(key, generator.makePrimitive());
    if (is_new) clustering.insert(key, place->second.embedding, place->second.box);
    return;
  }
  const int count = static_cast<int>(scene.primitives.size());
  const auto place = std::next(scene.primitives.begin(), generator.uniformInt(0, count - 1));
  if (action == 2) {
    clustering.erase(place->first);
    scene.primitives.erase(place);
    return;
  }
  const test::ReferencePrimitive fresh = generator.makePrimitive();
  if (generator.uniformInt(0, 1) == 0) place->second.box = fresh.box;
  if (generator.uniformInt(0, 1) == 0) place->second.embedding = fresh.embedding;
  clustering.update(place->first, place->second.embedding, place->second.box);
}

TEST_P(ClusteringVariants, IncrementalEqualsBatchAtEveryMoment) {
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    SceneGenerator generator(GetParam().options, seed);
    ReferenceScene scene;
    scene.tasks = generator.tasks();
    IncrementalClustering clustering = makeClustering(scene, GetParam().config);
    for (int step = 0; step < 60; ++step) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", step " + std::to_string(step));
      for (int i = generator.uniformInt(1, 3); i > 0; --i) change(generator, scene, clustering);
      expectEqual(clustering,
                  test::clusterDense(scene, test::findOverlaps(scene), GetParam().config));
      IncrementalClustering batch = makeClustering(scene, GetParam().config);
      ASSERT_EQ(clustering.information(), batch.information());
      if (HasFatalFailure()) return;
    }
  }
}

// One random change of the settings, or none.
void changeSettings(SceneGenerator& generator, ReferenceScene& scene, ClusteringConfig& config,
                    IncrementalClustering& clustering) {
  switch (generator.uniformInt(0, 5)) {
    case 0:
      clustering.setDelta(config.delta = generator.uniform(0.0, 0.1));
      break;
    case 1:
      clustering.setAlpha(config.alpha = generator.uniform(0.1, 0.5));
      break;
    case 2:
      clustering.setTopK(config.top_k = generator.uniformInt(1, 6));
      break;
    case 3:
      clustering.setTasks(scene.tasks = generator.makeTasks());
      break;
    case 4:
      config.prior = config.prior == Prior::kUniform ? Prior::kMarginal : Prior::kUniform;
      clustering.setConfig(config);
      break;
    default:
      break;
  }
}

TEST(Clustering, ChangesOfMapAndSettingsInAnyOrderGiveWhatABatchRunGives) {
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    SceneGenerator generator({}, seed);
    ReferenceScene scene;
    scene.tasks = generator.tasks();
    ClusteringConfig config;
    IncrementalClustering clustering = makeClustering(scene, config);
    for (int step = 0; step < 80; ++step) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", step " + std::to_string(step));
      for (int i = generator.uniformInt(0, 3); i > 0; --i) change(generator, scene, clustering);
      changeSettings(generator, scene, config, clustering);
      if (generator.uniformInt(0, 2) > 0) continue;  // let changes gather
      expectEqual(clustering, test::clusterDense(scene, test::findOverlaps(scene), config));
      if (HasFatalFailure()) return;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Configurations, ClusteringVariants, testing::ValuesIn(makeVariants()),
                         [](const auto& variant) { return variant.param.name; });

// As they are, and merge by merge to the end of the tapes: bit by bit.
void expectSameRun(IncrementalClustering& clustering, IncrementalClustering& batch) {
  ASSERT_EQ(partitionOf(clustering), partitionOf(batch));
  for (IncrementalClustering* each : {&clustering, &batch}) each->setDelta(1.0);
  const std::vector<Merge> ours = clustering.mergeSequence();
  const std::vector<Merge> theirs = batch.mergeSequence();
  ASSERT_EQ(ours.size(), theirs.size());
  for (std::size_t i = 0; i < ours.size(); ++i) {
    ASSERT_EQ(std::tie(ours[i].a, ours[i].b, ours[i].d),
              std::tie(theirs[i].a, theirs[i].b, theirs[i].d))
        << "merge " << i;
  }
}

// Large enough for the engine to follow former tapes.
TEST(Clustering, LargeComponentsChangedBitByBitEqualABatchRun) {
  SceneOptions options;
  options.num_primitives = 900;
  options.mean_degree = 12.0;
  SceneGenerator generator(options, 12);
  ReferenceScene scene = generator.makeScene();
  ClusteringConfig config;
  config.delta = 1e-4;
  IncrementalClustering clustering = makeClustering(scene, config);
  for (int step = 0; step < 40; ++step) {
    for (int i = generator.uniformInt(1, 4); i > 0; --i) change(generator, scene, clustering);
    IncrementalClustering batch = makeClustering(scene, config);
    SCOPED_TRACE("step " + std::to_string(step));
    expectSameRun(clustering, batch);
    EXPECT_GT(batch.mergeSequence().size(), 800u);
    if (HasFatalFailure()) return;
    clustering.setDelta(config.delta);
  }
}

// Large enough for the engine to follow former tapes.
TEST(Clustering, EdgesOfALargeGivenGraphChangedOneByOneEqualABatchRun) {
  constexpr int kCount = 700;
  SceneGenerator generator({}, 5);
  std::vector<Embedding> embeddings;
  std::set<test::KeyPair> edges;
  for (int i = 0; i < kCount; ++i) {
    embeddings.push_back(generator.makePrimitive().embedding);
    if (i > 0) edges.emplace(std::max(0, i - generator.uniformInt(1, 20)), i);
  }
  const auto make = [&] {
    IncrementalClustering clustering({}, Adjacency::kGiven);
    clustering.setTasks(generator.tasks());
    for (int i = 0; i < kCount; ++i) {
      clustering.insert(static_cast<NodeKey>(i), embeddings[static_cast<std::size_t>(i)]);
    }
    for (const auto& [a, b] : edges) clustering.insertEdge(a, b);
    return clustering;
  };
  IncrementalClustering clustering = make();
  for (int step = 0; step < 40; ++step) {
    const auto a = static_cast<NodeKey>(generator.uniformInt(0, kCount - 2));
    const auto b = static_cast<NodeKey>(generator.uniformInt(static_cast<int>(a) + 1, kCount - 1));
    const auto near =
        std::next(edges.begin(), generator.uniformInt(0, static_cast<int>(edges.size()) - 1));
    if (step % 3 == 0) {
      clustering.eraseEdge(near->first, near->second);  // splits the component: a tree at first
      edges.erase(near);
    } else if (edges.emplace(a, b).second) {
      clustering.insertEdge(a, b);
    }
    IncrementalClustering batch = make();
    SCOPED_TRACE("step " + std::to_string(step));
    expectSameRun(clustering, batch);
    if (HasFatalFailure()) return;
    clustering.setDelta(1e-5);
  }
}

TEST(Clustering, EverySetterGivesWhatABatchRunWithThatConfigurationGives) {
  SceneGenerator generator({}, 3);
  ReferenceScene scene = generator.makeScene();
  ClusteringConfig config;
  IncrementalClustering clustering = makeClustering(scene, config);
  const auto check = [&] {
    expectEqual(clustering, test::clusterDense(scene, test::findOverlaps(scene), config));
  };
  check();
  for (const double delta : {0.0, 0.05, 0.5, 1.0, 1e-3}) {
    clustering.setDelta(config.delta = delta);
    check();
  }
  clustering.setAlpha(config.alpha = 0.6);
  check();
  clustering.setTopK(config.top_k = 4);
  check();
  clustering.setTasks(scene.tasks = generator.makeTasks());
  check();
  config.prior = Prior::kMarginal;
  config.cumulative = false;
  clustering.setConfig(config);
  check();
}

TEST(Clustering, GivenEdgesRestrictMerges) {
  SceneGenerator generator({}, 8);
  const ReferenceScene scene = generator.makeScene();
  ClusteringConfig config;
  config.delta = 0.05;
  IncrementalClustering clustering(config, Adjacency::kGiven);
  clustering.setTasks(scene.tasks);
  std::vector<NodeKey> keys;
  for (const auto& [key, primitive] : scene.primitives) {
    clustering.insert(key, primitive.embedding);
    keys.push_back(key);
  }
  std::vector<test::KeyPair> edges;
  for (int step = 0; step < 80; ++step) {
    const auto pick = [&] { return keys[static_cast<std::size_t>(generator.uniformInt(0, 29))]; };
    const auto edge = std::minmax({pick(), pick()});
    if (edge.first == edge.second) continue;
    const auto place = std::find(edges.begin(), edges.end(), test::KeyPair(edge));
    if (place != edges.end()) {
      EXPECT_TRUE(clustering.eraseEdge(edge.second, edge.first));
      EXPECT_FALSE(clustering.eraseEdge(edge.first, edge.second));
      edges.erase(place);
    } else {
      EXPECT_TRUE(clustering.insertEdge(edge.second, edge.first));
      EXPECT_FALSE(clustering.insertEdge(edge.first, edge.second));
      edges.push_back(edge);
    }
    expectEqual(clustering, test::clusterDense(scene, edges, config));
  }
}

TEST(Clustering, SumsOfRelevanceAreThoseOfThePrimitivesThatAreThere) {
  SceneGenerator generator({}, 4);
  const ReferenceScene scene = generator.makeScene();
  IncrementalClustering clustering = makeClustering(scene, ClusteringConfig{});
  std::vector<NodeKey> keys;
  SparseMasses expected;
  for (const auto& [key, primitive] : scene.primitives) {
    if (key % 3 == 0) continue;
    keys.push_back(key);
    expected = addMasses(expected, clustering.relevance(key));
  }
  const std::size_t count = keys.size();
  ASSERT_GT(count, 5U);
  keys.push_back(scene.primitives.rbegin()->first + 1);  // not there
  EXPECT_EQ(clustering.sumRelevance(keys), std::pair(expected, count));
  EXPECT_TRUE(clustering.sumRelevance({}).first.empty());
}

TEST(Clustering, DeltaZeroKeepsThePrimitivesAndOneMergesComponentsWhole) {
  SceneGenerator generator({}, 21);
  const ReferenceScene scene = generator.makeScene();
  for (const Prior prior : {Prior::kUniform, Prior::kMarginal}) {
    ClusteringConfig config;
    config.prior = prior;
    config.delta = 0.0;
    IncrementalClustering clustering = makeClustering(scene, config);
    EXPECT_EQ(clustering.clusters().size(), scene.primitives.size());
    clustering.setDelta(1.0);
    const Partition whole = partitionOf(clustering);
    for (const auto& [a, b] : test::findOverlaps(scene)) {
      EXPECT_EQ(clustering.clusterOf(a), clustering.clusterOf(b));
    }
    EXPECT_LT(whole.size(), scene.primitives.size());
  }
}

TEST(Clustering, BadInputNamesThePrimitiveAndBothDimensions) {
  IncrementalClustering clustering({}, Adjacency::kBoxOverlap);
  EmbeddingMatrix tasks = EmbeddingMatrix::Identity(2, 3);
  clustering.setTasks(tasks);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(messageOf([&] { clustering.insert(17, Embedding::Zero(3)); }),
            "the embedding of primitive 17 is zero; expected a finite vector other than zero");
  EXPECT_NE(messageOf([&] {
              clustering.insert(18, Embedding::Constant(3, nan));
            }).find("primitive 18 has an entry that is not finite"),
            std::string::npos);
  EXPECT_EQ(messageOf([&] { clustering.insert(19, Embedding::Ones(4)); }),
            "the embedding of primitive 19 has dimension 4; expected 3 as the tasks");
  EXPECT_EQ(clustering.size(), 0u);
  clustering.insert(20, Embedding::Ones(3));
  EXPECT_NE(messageOf([&] { clustering.insert(20, Embedding::Ones(3)); }).find("primitive 20"),
            std::string::npos);
  EXPECT_NE(messageOf([&] { clustering.update(20, Embedding::Zero(3)); }).find("primitive 20"),
            std::string::npos);
  EXPECT_NE(messageOf([&] { clustering.erase(21); }).find("primitive 21"), std::string::npos);
  EXPECT_EQ(messageOf([&] { clustering.setTasks(EmbeddingMatrix::Identity(2, 5)); }),
            "the task embeddings have dimension 5, those of the primitives 3; expected the same");
  tasks.row(1).setZero();
  EXPECT_NE(messageOf([&] { clustering.setTasks(tasks); }).find("task 1"), std::string::npos);
  EXPECT_EQ(clustering.scores(20).size(), 2u);
}

TEST(Clustering, EdgesAreCheckedByKind) {
  IncrementalClustering boxes({}, Adjacency::kBoxOverlap);
  EXPECT_THROW(boxes.insertEdge(1, 2), std::logic_error);
  IncrementalClustering given({}, Adjacency::kGiven);
  given.insert(1, Embedding::Ones(2));
  EXPECT_THROW(given.insertEdge(1, 1), std::invalid_argument);
  EXPECT_NE(messageOf([&] { given.insertEdge(1, 2); }).find("primitive 2"), std::string::npos);
}

TEST(Clustering, BadConfigurationIsRejectedAndTheFormerStays) {
  IncrementalClustering clustering({}, Adjacency::kGiven);
  EXPECT_THROW(clustering.setAlpha(1.5), config::ConfigError);
  EXPECT_THROW(clustering.setDelta(-0.1), config::ConfigError);
  EXPECT_THROW(clustering.setTopK(0), config::ConfigError);
  EXPECT_EQ(clustering.config().alpha, 0.23);
}

}  // namespace
}  // namespace tsg::bottleneck
