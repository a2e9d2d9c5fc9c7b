// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/bottleneck/explanation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "bottleneck_reference.h"
#include "task_scene_graph/bottleneck/clustering.h"

namespace tsg::bottleneck {
namespace {

using Verdict = PairExplanation::Verdict;

struct ExplainedScene {
  explicit ExplainedScene(std::uint32_t seed) {
    test::SceneOptions options;
    options.num_primitives = 40;
    scene = test::SceneGenerator(options, seed).makeScene();
    ClusteringConfig config;
    config.delta = 0.01;
    clustering.setConfig(config);
    clustering.setTasks(scene.tasks);
    for (const auto& [key, primitive] : scene.primitives) {
      clustering.insert(key, primitive.embedding, primitive.box);
    }
  }
  test::ReferenceScene scene;
  IncrementalClustering clustering{ClusteringConfig(), Adjacency::kBoxOverlap};
};

void expectNear(const SparseMasses& a, const SparseMasses& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].task, b[i].task);
    EXPECT_NEAR(a[i].mass, b[i].mass, 1e-12);
  }
}

TEST(Explanation, MergesOfAClusterJoinItsPrimitivesIntoItsDistribution) {
  for (std::uint32_t seed = 1; seed < 6; ++seed) {
    ExplainedScene s(seed);
    std::size_t num_merges = 0;
    for (const Cluster& cluster : s.clustering.clusters()) {
      const ClusterExplanation explanation = s.clustering.explainCluster(cluster.id);
      EXPECT_EQ(explanation.task, cluster.task);
      ASSERT_EQ(explanation.merges.size() + 1, cluster.members.size());
      std::set<NodeKey> joined;
      for (const ExplainedMerge& merge : explanation.merges) {
        EXPECT_LT(merge.delta, explanation.threshold);
        EXPECT_TRUE(joined.insert(merge.b).second);
        EXPECT_TRUE(std::binary_search(cluster.members.begin(), cluster.members.end(), merge.a));
      }
      if (!explanation.merges.empty()) {
        expectNear(explanation.merges.back().after, cluster.relevance);
      }
      if (explanation.stop) {
        EXPECT_GE(explanation.stop->delta, explanation.threshold);
      }
      num_merges += explanation.merges.size();
    }
    EXPECT_EQ(num_merges, s.clustering.mergeSequence().size());
  }
}

TEST(Explanation, PairsAreTogetherByAMergeOrApartByARejectedOne) {
  std::set<Verdict> seen;
  for (std::uint32_t seed = 1; seed < 4; ++seed) {
    ExplainedScene s(seed);
    for (const auto& [a, x] : s.scene.primitives) {
      for (const auto& [b, z] : s.scene.primitives) {
        if (a == b) continue;
        const PairExplanation pair = s.clustering.explainPair(a, b);
        seen.insert(pair.verdict);
        const bool is_together = s.clustering.clusterOf(a) == s.clustering.clusterOf(b);
        EXPECT_EQ(pair.verdict == Verdict::kTogether, is_together);
        EXPECT_EQ(pair.merge.has_value(), pair.verdict != Verdict::kNotConnected);
        EXPECT_EQ(pair.stop.has_value(), pair.verdict == Verdict::kApart);
        if (is_together) {
          EXPECT_LT(pair.merge->delta, pair.threshold);
        }
        if (pair.stop) {
          EXPECT_GE(pair.stop->delta, pair.threshold);
        }
      }
    }
  }
  EXPECT_EQ(seen.size(), 3u);
}

TEST(Explanation, PrunedPrimitivesSayWhichScoreFellShort) {
  IncrementalClustering clustering({}, Adjacency::kGiven);
  EmbeddingMatrix tasks = EmbeddingMatrix::Zero(2, 3);
  tasks(0, 0) = tasks(1, 1) = 1.0f;
  clustering.setTasks(tasks);
  clustering.insert(1, Embedding(Eigen::Vector3f(0.1f, 0.2f, 1.0f)));
  clustering.insert(2, Embedding(Eigen::Vector3f(0.1f, 2.0f, 1.0f)));
  const PrimitiveExplanation pruned = clustering.explainPrimitive(1);
  EXPECT_TRUE(pruned.is_pruned);
  EXPECT_EQ(pruned.best_task, 2);
  EXPECT_NEAR(pruned.best_score, 0.2 / std::sqrt(1.05), 1e-7);
  EXPECT_EQ(pruned.alpha, 0.23);
  EXPECT_EQ(pruned.relevance, (SparseMasses{{0, 1.0}}));
  EXPECT_FALSE(clustering.explainPrimitive(2).is_pruned);
  EXPECT_THROW(clustering.explainPrimitive(3), std::invalid_argument);
  EXPECT_THROW(clustering.explainCluster(77), std::out_of_range);
}

TEST(Statistics, InformationKeptAndLostAddUp) {
  ExplainedScene s(2);
  const ClusteringStatistics statistics = s.clustering.statistics();
  const auto merges = s.clustering.mergeSequence();
  const auto clusters = s.clustering.clusters();
  EXPECT_EQ(statistics.num_primitives, 40u);
  EXPECT_EQ(statistics.num_clusters, clusters.size());
  EXPECT_EQ(statistics.deltas.size(), merges.size());
  EXPECT_NEAR(statistics.compression_ratio, 40.0 / static_cast<double>(clusters.size()), 1e-12);
  double kept = 0.0;  // I(X~;Y) with uniform p(y), from the clusters alone
  double entropy = 0.0;
  for (const Cluster& cluster : clusters) {
    const double share = static_cast<double>(cluster.members.size()) / 40.0;
    kept += share * (std::log2(6.0) - computeEntropyBits(cluster.relevance));
    entropy -= share * std::log2(share);
  }
  EXPECT_NEAR(statistics.kept_bits, kept, 1e-9);
  EXPECT_NEAR(statistics.compression_bits, entropy, 1e-12);
  EXPECT_LT(statistics.kept_bits, statistics.information_bits);
}

}  // namespace
}  // namespace tsg::bottleneck
