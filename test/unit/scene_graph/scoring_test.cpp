// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/scoring.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "random_world.h"
#include "sample_graph.h"

namespace tsg::scene_graph {
namespace {

TEST(BestTask, IsTheOneOfHighestCosineNotOfLargestProduct) {
  EmbeddingMatrix tasks(3, 2);
  tasks << 10.0F, 10.0F, 0.1F, 0.0F, -1.0F, 0.0F;
  const TaskScore best = findBestTask(makeEmbedding({3, 0.3F}), bottleneck::TaskScorer(tasks));
  EXPECT_EQ(best.task_index, 1);
  EXPECT_NEAR(best.cosine, 3.0 / std::hypot(3.0, 0.3), 1e-6);
}

TEST(BestTask, IsTheFirstOfEqualOnesAndMayBeNegative) {
  EmbeddingMatrix tasks(3, 2);
  tasks << -1.0F, 0.0F, -1.0F, 0.0F, -1.0F, 0.0F;
  const TaskScore best = findBestTask(makeEmbedding({2, 0}), bottleneck::TaskScorer(tasks));
  EXPECT_EQ(best.task_index, 0);
  EXPECT_NEAR(best.cosine, -1.0, 1e-6);
}

TEST(BestTask, IsNoneWithoutTasksOrDirection) {
  EXPECT_EQ(findBestTask(makeEmbedding({2, 0}), {}).task_index, -1);
  const bottleneck::TaskScorer tasks(EmbeddingMatrix::Ones(1, 2));
  EXPECT_EQ(findBestTask(makeEmbedding({0, 0}), tasks).task_index, -1);
  EXPECT_EQ(findBestTask(makeEmbedding({0, 0}), tasks).cosine, 0.0);
}

TEST(CosineSummary, HoldsTheBestCosinesOfWhatHasADirection) {
  EmbeddingMatrix tasks(2, 2);
  tasks << 1.0F, 0.0F, 0.0F, 1.0F;
  const std::vector<Embedding> embeddings{makeEmbedding({0.6F, 0.8F}), makeEmbedding({-1, 0}),
                                          makeEmbedding({1, 0.1F}), makeEmbedding({0, 0}),
                                          Embedding()};
  std::vector<const Embedding*> pointers;
  for (const Embedding& embedding : embeddings) pointers.push_back(&embedding);
  const CosineSummary summary = summarizeCosines(pointers, bottleneck::TaskScorer(tasks));
  EXPECT_EQ(summary.count, 3U);
  EXPECT_NEAR(summary.highest, 1.0 / std::hypot(1.0, 0.1), 1e-6);
  EXPECT_EQ(summary.task_index, 0);
  EXPECT_NEAR(summary.median, 0.8, 1e-6);
  EXPECT_NEAR(summary.lowest, 0.0, 1e-6);
}

TEST(CosineSummary, IsEmptyWithoutTasks) {
  const Embedding embedding = makeEmbedding({1, 0});
  EXPECT_EQ(summarizeCosines({&embedding}, {}).count, 0U);
}

TEST(Direction, NeedsFiniteValuesThatAreNotAllZero) {
  EXPECT_TRUE(hasDirection(makeEmbedding({0, 1e-30F})));
  EXPECT_FALSE(hasDirection({}));
  EXPECT_FALSE(hasDirection(makeEmbedding({0, 0})));
  EXPECT_FALSE(hasDirection(makeEmbedding({1, std::numeric_limits<float>::quiet_NaN()})));
  EXPECT_FALSE(hasDirection(makeEmbedding({1, std::numeric_limits<float>::infinity()})));
}

TEST(MeanEmbedding, IsTheArithmeticMean) {
  EmbeddingMean mean;
  EXPECT_EQ(mean.mean().size(), 0);
  mean.add(makeEmbedding({1, 0}));
  mean.add(makeEmbedding({4, -3}));
  mean.add(makeEmbedding({1, 0}));
  EXPECT_EQ(mean.mean(), makeEmbedding({2, -1}));
}

TEST(MeanEmbedding, DoesNotLoseSmallTermsBesideLargeOnes) {
  EmbeddingMean mean;
  for (int i = 0; i < 1000; ++i) {
    mean.add(makeEmbedding({1e7F}));
    mean.add(makeEmbedding({0.25F}));
    mean.add(makeEmbedding({-1e7F}));
  }
  EXPECT_FLOAT_EQ(mean.mean()[0], 0.25F / 3.0F);
}

}  // namespace
}  // namespace tsg::scene_graph
