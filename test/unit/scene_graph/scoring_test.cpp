// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/scoring.h"

#include <gtest/gtest.h>

#include <limits>

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
