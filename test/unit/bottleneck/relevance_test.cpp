// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/bottleneck/relevance.h"

#include <gtest/gtest.h>

#include "bottleneck_reference.h"
#include "task_scene_graph/bottleneck/clustering.h"

namespace tsg::bottleneck {
namespace {

// The published unit cases: features e_0..e_4 of R^10, tasks e_0, e_1, e_2. They differ from what
// is computed here in two ways: the published code fills zeros with 1e-12, and breaks ties of equal
// scores by sorting order; here zeros are zeros, and the smaller index wins.
EmbeddingMatrix makePublishedTasks() {
  EmbeddingMatrix tasks = EmbeddingMatrix::Zero(3, 10);
  for (int j = 0; j < 3; ++j) tasks(j, j) = 1.0f;
  return tasks;
}

SparseMasses relevanceOf(const Embedding& x, const ClusteringConfig& config) {
  return computeRelevance(TaskScorer(makePublishedTasks()).computeScores(x), config);
}

ClusteringConfig makeConfig(double alpha, int top_k, bool prune, bool cumulative) {
  ClusteringConfig config;
  config.alpha = alpha;
  config.top_k = top_k;
  config.prune_null = prune;
  config.cumulative = cumulative;
  return config;
}

const SparseMasses kNull{{0, 1.0}};

TEST(Relevance, PublishedCaseAlphaOneAllTasks) {
  const ClusteringConfig config = makeConfig(1.0, 100, false, false);
  for (std::uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(relevanceOf(Embedding::Unit(10, i), config), (SparseMasses{{0, 0.5}, {i + 1, 0.5}}));
  }
  EXPECT_EQ(relevanceOf(Embedding::Unit(10, 3), config), kNull);
  EXPECT_EQ(relevanceOf(Embedding::Unit(10, 4), config), kNull);
}

TEST(Relevance, PublishedCaseTopOne) {
  const ClusteringConfig config = makeConfig(0.9, 1, false, false);
  for (std::uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(relevanceOf(Embedding::Unit(10, i), config), (SparseMasses{{i + 1, 1.0}}));
  }
  EXPECT_EQ(relevanceOf(Embedding::Unit(10, 3), config), kNull);
}

TEST(Relevance, PublishedCaseTopTwoCumulative) {
  const SparseMasses p = relevanceOf(Embedding::Unit(10, 0), makeConfig(0.9, 2, false, true));
  ASSERT_EQ(p.size(), 2u);
  EXPECT_NEAR(p[0].mass, 0.9 / 2.9, 1e-15);
  EXPECT_NEAR(p[1].mass, 2.0 / 2.9, 1e-15);
  EXPECT_EQ(relevanceOf(Embedding::Unit(10, 3), makeConfig(0.9, 2, false, true)), kNull);
}

TEST(Relevance, PublishedCasePruning) {
  const ClusteringConfig config = makeConfig(0.9, 100, true, false);
  const SparseMasses p = relevanceOf(Embedding::Unit(10, 1), config);
  ASSERT_EQ(p.size(), 2u);
  EXPECT_NEAR(p[0].mass, 0.9 / 1.9, 1e-15);
  EXPECT_NEAR(p[1].mass, 1.0 / 1.9, 1e-15);
  EXPECT_EQ(relevanceOf(Embedding::Unit(10, 3) + Embedding::Unit(10, 0), config), kNull);
}

// The published Python case resolves the tie of x = (1, 1, 0) to the second task; here the first.
TEST(Relevance, PublishedPythonCaseWithTheTieGoingToTheFirstTask) {
  EmbeddingMatrix tasks(2, 3);
  tasks << 1, 0, 0, 0, 1, 0;
  const TaskScorer scorer(tasks);
  const ClusteringConfig config = makeConfig(0.2, 2, true, true);
  const auto p = [&](float a, float b) {
    return computeRelevance(scorer.computeScores(Embedding(Eigen::Vector3f(a, b, 0))), config);
  };
  ASSERT_EQ(p(1, 0).size(), 2u);
  EXPECT_NEAR(p(1, 0)[0].mass, 0.2 / 2.2, 1e-15);
  EXPECT_NEAR(p(1, 0)[1].mass, 2.0 / 2.2, 1e-15);
  EXPECT_EQ(p(0, 1)[1].task, 2u);
  const SparseMasses tie = p(1, 1);
  ASSERT_EQ(tie.size(), 2u);
  EXPECT_EQ(tie[0].task, 1u);
  EXPECT_NEAR(tie[0].mass, 2.0 / 3.0, 1e-15);
  EXPECT_NEAR(tie[1].mass, 1.0 / 3.0, 1e-15);
}

TEST(Relevance, AScoreOfExactlyAlphaIsNotPrunedAndTheNullTaskWinsTheTie) {
  const SparseMasses p = relevanceOf(Embedding::Unit(10, 2), makeConfig(1.0, 2, true, true));
  ASSERT_EQ(p.size(), 2u);
  EXPECT_NEAR(p[0].mass, 2.0 / 3.0, 1e-15);
  EXPECT_NEAR(p[1].mass, 1.0 / 3.0, 1e-15);
}

TEST(Relevance, NegativeCosinesCountAsZero) {
  Embedding x = Embedding::Unit(10, 0) - 0.5f * Embedding::Unit(10, 1);
  const SparseMasses p = relevanceOf(x, makeConfig(0.2, 4, true, false));
  ASSERT_EQ(p.size(), 2u);
  EXPECT_EQ(p[1].task, 1u);
  EXPECT_EQ(relevanceOf(-Embedding::Unit(10, 0), makeConfig(0.0, 2, true, true)), kNull);
  EXPECT_EQ(relevanceOf(-Embedding::Unit(10, 0), makeConfig(0.0, 2, false, true)), kNull);
}

TEST(Relevance, EqualsTheDenseReferenceOnRandomScenes) {
  for (const int top_k : {1, 2, 3, 100}) {
    test::SceneOptions options;
    options.num_tasks = 11;
    const test::ReferenceScene scene = test::SceneGenerator(options, 9).makeScene();
    ClusteringConfig config;
    config.top_k = top_k;
    const Eigen::MatrixXd expected = test::computeDenseRelevance(scene, config);
    const TaskScorer scorer(scene.tasks);
    Eigen::Index column = 0;
    for (const auto& [key, primitive] : scene.primitives) {
      Eigen::VectorXd dense = Eigen::VectorXd::Zero(expected.rows());
      for (const TaskMass& y :
           computeRelevance(scorer.computeScores(primitive.embedding), config)) {
        dense[y.task] = y.mass;
      }
      EXPECT_LT((dense - expected.col(column++)).cwiseAbs().maxCoeff(), 1e-14);
    }
  }
}

TEST(Relevance, AScoreDoesNotDependOnTheOtherTasks) {
  test::SceneOptions options;
  options.num_tasks = 21;
  options.dimension = 77;
  test::SceneGenerator generator(options, 2);
  const EmbeddingMatrix tasks = generator.tasks();
  const Embedding x = generator.makePrimitive().embedding;
  const std::vector<double> all = TaskScorer(tasks).computeScores(x);
  for (int j = 0; j < 21; ++j) {
    EXPECT_EQ(TaskScorer(tasks.row(j)).computeScores(x)[0], all[static_cast<std::size_t>(j)]);
    EXPECT_NEAR(all[static_cast<std::size_t>(j)], computeCosine(x, tasks.row(j).transpose()), 1e-6);
  }
}

// Published case: after merging (0, 1) p(y|z) = (.5, .25, .25, 0).
TEST(Relevance, PublishedUpdateOfAMerge) {
  IncrementalClustering clustering(makeConfig(1.0, 100, false, false), Adjacency::kGiven);
  clustering.setTasks(makePublishedTasks());
  for (NodeKey i = 0; i < 5; ++i) clustering.insert(i, Embedding::Unit(10, static_cast<int>(i)));
  clustering.insertEdge(0, 1);
  clustering.setDelta(1.0);
  const auto cluster = clustering.clusters()[0];
  EXPECT_EQ(cluster.members, (std::vector<NodeKey>{0, 1}));
  EXPECT_EQ(cluster.relevance, (SparseMasses{{0, 0.5}, {1, 0.25}, {2, 0.25}}));
}

}  // namespace
}  // namespace tsg::bottleneck
