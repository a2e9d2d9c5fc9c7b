// SPDX-License-Identifier: BSD-3-Clause
// Properties of the clustering as a whole.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "bottleneck/information.h"
#include "clustering_fixtures.h"

namespace tsg::bottleneck {
namespace {

using test::ReferenceScene;
using test::SceneGenerator;
using test::SceneOptions;

class Seeds : public testing::TestWithParam<std::uint32_t> {
 protected:
  ReferenceScene makeScene(const SceneOptions& options = {}) const {
    return SceneGenerator(options, GetParam()).makeScene();
  }
};
INSTANTIATE_TEST_SUITE_P(Properties, Seeds, testing::Range(100u, 110u));

TEST_P(Seeds, EveryMergeLosesExactlyItsDAndInformationNeverIncreases) {
  const ReferenceScene scene = makeScene();
  ClusteringConfig config;
  config.delta = 1.0;
  auto clustering = makeClustering(scene, config);
  const auto reference = test::clusterDense(scene, test::findOverlaps(scene), config);
  const auto merges = clustering.mergeSequence();
  ASSERT_EQ(merges.size(), reference.losses.size());
  for (std::size_t i = 0; i < merges.size(); ++i) {
    EXPECT_GE(merges[i].d, 0.0);
    EXPECT_NEAR(merges[i].d, reference.losses[i], 1e-10);
  }
}

// Eq. (6): delta_c = |X_c| / |X| times the loss within the component, over I(X;Y) of the whole.
TEST_P(Seeds, DeltaOfAComponentIsThatOfAppendixB) {
  const ReferenceScene scene = makeScene();
  ClusteringConfig config;
  config.delta = 1.0;
  auto part = makeClustering(scene, config);
  auto whole = makeClustering(scene, config);
  SceneGenerator generator({}, GetParam() + 1);
  for (NodeKey i = 0; i < 50; ++i) {
    const auto primitive = generator.makePrimitive();
    const Eigen::Vector3d far = Eigen::Vector3d::Constant(1000.0);
    whole.insert(10'000'000 + i, primitive.embedding,
                 makeAabb(far + primitive.box.min(), far + primitive.box.max()));
  }
  std::vector<Merge> inside = whole.mergeSequence();
  const auto is_outside = [](const Merge& merge) { return merge.a >= 10'000'000; };
  inside.erase(std::remove_if(inside.begin(), inside.end(), is_outside), inside.end());
  const std::vector<Merge> alone = part.mergeSequence();
  ASSERT_EQ(inside.size(), alone.size());
  for (std::size_t i = 0; i < alone.size(); ++i) {
    EXPECT_EQ(inside[i].a, alone[i].a);
    EXPECT_EQ(inside[i].b, alone[i].b);
    EXPECT_NEAR(inside[i].delta, 30.0 / 80.0 * alone[i].d / whole.information(), 1e-12);
  }
}

TEST_P(Seeds, TheSumOfAllDIsTheInformationLessWhatRemains) {
  const ReferenceScene scene = makeScene();
  for (const Prior prior : {Prior::kUniform, Prior::kMarginal}) {
    ClusteringConfig config;
    config.delta = 0.02;
    config.prior = prior;
    auto clustering = makeClustering(scene, config);
    double lost = 0.0;
    for (const Merge& merge : clustering.mergeSequence()) lost += merge.d;
    InformationSum remaining;  // each cluster's p(y) once per primitive
    for (const Cluster& cluster : clustering.clusters()) {
      for (std::size_t i = 0; i < cluster.members.size(); ++i) remaining.add(cluster.relevance);
    }
    const double left = remaining.computeTotalBits(prior, 5) / 30.0;
    EXPECT_NEAR(lost, clustering.information() - left, 1e-8);
  }
}

TEST_P(Seeds, WholeConnectedGraphLosesAllOfItsMutualInformation) {
  SceneOptions options;
  options.mean_degree = 400.0;  // one component
  const ReferenceScene scene = makeScene(options);
  ClusteringConfig config;
  config.prior = Prior::kMarginal;
  config.delta = 1.0;
  auto clustering = makeClustering(scene, config);
  ASSERT_EQ(clustering.clusters().size(), 1u);
  double lost = 0.0;
  for (const Merge& merge : clustering.mergeSequence()) lost += merge.d;
  EXPECT_NEAR(lost, clustering.information(), 1e-8);
}

TEST_P(Seeds, InsertionOrderChangesNothing) {
  const ReferenceScene scene = makeScene();
  ClusteringConfig config;
  config.delta = 0.02;
  auto batch = makeClustering(scene, config);
  std::vector<NodeKey> keys;
  for (const auto& [key, primitive] : scene.primitives) keys.push_back(key);
  std::mt19937 random(GetParam());
  std::shuffle(keys.begin(), keys.end(), random);
  IncrementalClustering one_by_one(config, Adjacency::kBoxOverlap);
  one_by_one.setTasks(scene.tasks);
  for (const NodeKey key : keys) {
    one_by_one.insert(key, scene.primitives.at(key).embedding, scene.primitives.at(key).box);
    one_by_one.applyChanges();
  }
  EXPECT_EQ(partitionOf(one_by_one), partitionOf(batch));
  EXPECT_EQ(one_by_one.information(), batch.information());
}

// Without ties; ties go by id, so there a permutation of ids may rightly change the merges.
SceneOptions makeTieFree() {
  SceneOptions options;
  options.duplicate_share = 0.0;
  return options;
}

ClusteringConfig makeTieFreeConfig() {
  ClusteringConfig config = makePublishedConfig(0.05, 100, true, false);
  config.delta = 0.02;
  return config;
}

TEST_P(Seeds, PermutingPrimitivesChangesOnlyTheirIds) {
  const ReferenceScene scene = makeScene(makeTieFree());
  std::vector<NodeKey> keys;
  for (const auto& [key, primitive] : scene.primitives) keys.push_back(key);
  std::vector<NodeKey> renamed = keys;
  std::mt19937 random(GetParam());
  std::shuffle(renamed.begin(), renamed.end(), random);
  ReferenceScene other;
  other.tasks = scene.tasks;
  std::map<NodeKey, NodeKey> original;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    other.primitives[renamed[i]] = scene.primitives.at(keys[i]);
    original[renamed[i]] = keys[i];
  }
  auto clustering = makeClustering(scene, makeTieFreeConfig());
  auto permuted = makeClustering(other, makeTieFreeConfig());
  Partition back = partitionOf(permuted);
  for (auto& members : back) {
    for (NodeKey& key : members) key = original.at(key);
    std::sort(members.begin(), members.end());
  }
  std::sort(back.begin(), back.end());
  EXPECT_EQ(back, partitionOf(clustering));
  EXPECT_LT(back.size(), 30u);
}

TEST_P(Seeds, PermutingTasksChangesOnlyTheirNumbers) {
  ReferenceScene scene = makeScene(makeTieFree());
  auto clustering = makeClustering(scene, makeTieFreeConfig());
  scene.tasks = EmbeddingMatrix(scene.tasks.colwise().reverse());
  auto permuted = makeClustering(scene, makeTieFreeConfig());
  EXPECT_EQ(partitionOf(permuted), partitionOf(clustering));
  EXPECT_NEAR(permuted.information(), clustering.information(), 1e-12);
  for (const Cluster& cluster : clustering.clusters()) {
    const auto id = permuted.clusterOf(cluster.members[0]);
    for (const Cluster& other : permuted.clusters()) {
      if (other.id != id) continue;
      EXPECT_EQ(other.task, cluster.task == 0 ? 0 : 6 - cluster.task);
    }
  }
}

TEST_P(Seeds, ThreadsDoNotChangeResults) {
  const ReferenceScene scene = makeScene();
  ClusteringConfig config;
  config.delta = 0.02;
  auto one = makeClustering(scene, config);
  config.num_threads = 4;
  auto four = makeClustering(scene, config);
  EXPECT_EQ(partitionOf(one), partitionOf(four));
}

TEST_P(Seeds, SizeInvariantClustersStayAsTheMapGrowsElsewhere) {
  ReferenceScene scene = makeScene();
  ClusteringConfig config;
  config.normaliser = Normaliser::kSizeInvariant;
  config.delta_bits = 0.2;
  auto clustering = makeClustering(scene, config);
  const Partition before = partitionOf(clustering);
  SceneGenerator generator({}, GetParam() + 1);
  for (NodeKey i = 0; i < 100; ++i) {
    const auto primitive = generator.makePrimitive();
    const Eigen::Vector3d far(1000.0 + 10.0 * static_cast<double>(i), 0, 0);
    clustering.insert(10'000'000 + i, primitive.embedding,
                      makeAabb(far, far + Eigen::Vector3d::Ones()));
  }
  Partition after = partitionOf(clustering);
  after.resize(after.size() - 100);
  EXPECT_EQ(after, before);
}

TEST(EdgeCases, AllNullComponentsBecomeOneClusterEach) {
  ClusteringConfig config;
  for (const Prior prior : {Prior::kUniform, Prior::kMarginal}) {
    config.prior = prior;
    IncrementalClustering clustering(config, Adjacency::kGiven);
    clustering.setTasks(EmbeddingMatrix::Identity(1, 3));
    for (NodeKey key = 0; key < 6; ++key) clustering.insert(key, Embedding::Unit(3, 1));
    clustering.insertEdge(0, 1);
    clustering.insertEdge(1, 2);
    clustering.insertEdge(4, 5);
    EXPECT_EQ(partitionOf(clustering), (Partition{{0, 1, 2}, {3}, {4, 5}}));
    for (const Cluster& cluster : clustering.clusters()) EXPECT_EQ(cluster.task, 0);
  }
}

TEST(EdgeCases, NoTaskNoPrimitiveOnePrimitive) {
  IncrementalClustering clustering({}, Adjacency::kBoxOverlap);
  EXPECT_TRUE(clustering.clusters().empty());
  EXPECT_EQ(clustering.information(), 0.0);
  EXPECT_EQ(clustering.statistics().num_clusters, 0u);
  const Aabb box = makeAabb({0, 0, 0}, {1, 1, 1});
  clustering.insert(5, Embedding::Ones(4), box);
  ASSERT_EQ(clustering.clusters().size(), 1u);
  EXPECT_EQ(clustering.clusters()[0].relevance, (SparseMasses{{0, 1.0}}));
  clustering.insert(6, Embedding::Unit(4, 2), box);
  EXPECT_EQ(partitionOf(clustering), (Partition{{5, 6}}));  // both null: nothing to lose
  clustering.setTasks(EmbeddingMatrix::Identity(2, 4));
  EXPECT_EQ(clustering.clusters().size(), 2u);
  clustering.erase(5);
  clustering.erase(6);
  EXPECT_TRUE(clustering.clusters().empty());
}

TEST(EdgeCases, OneHotPrimitivesOfOneTaskMergeForNothingAndOfTwoForTwoBits) {
  ClusteringConfig config = makePublishedConfig(0.1, 1, true, true);
  config.delta = 1.0;
  auto clustering = makeFromScores({{1, 0}, {1, 0}, {0, 1}}, {{0, 1}, {1, 2}}, config);
  const auto merges = clustering.mergeSequence();
  ASSERT_EQ(merges.size(), 2u);
  EXPECT_EQ(merges[0].d, 0.0);
  EXPECT_NEAR(merges[1].d, computeMixingBits(2, 1) / 3.0, 1e-9);
}

TEST(EdgeCases, DuplicatesAreMergedForNothingWhateverTheDelta) {
  SceneGenerator generator({}, 4);
  const Embedding x = generator.makePrimitive().embedding;
  ClusteringConfig config;
  config.delta = 1e-12;
  IncrementalClustering clustering(config, Adjacency::kBoxOverlap);
  clustering.setTasks(generator.tasks());
  const Aabb box = makeAabb({0, 0, 0}, {1, 1, 1});
  for (NodeKey key = 0; key < 300; ++key) clustering.insert(key, x, box);
  ASSERT_EQ(clustering.clusters().size(), 1u);
  for (const Merge& merge : clustering.mergeSequence()) EXPECT_EQ(merge.d, 0.0);
}

}  // namespace
}  // namespace tsg::bottleneck
