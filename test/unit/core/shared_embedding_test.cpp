// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/shared_embedding.h"

#include <gtest/gtest.h>

#include <limits>

namespace tsg {
namespace {

Embedding makeEmbedding(float first, float second) {
  Embedding embedding(2);
  embedding << first, second;
  return embedding;
}

TEST(SharedEmbedding, OfNothingIsEmptyAndEqualToAnyOther) {
  EXPECT_EQ(SharedEmbedding().size(), 0);
  EXPECT_EQ(SharedEmbedding()->size(), 0);
  EXPECT_TRUE(SharedEmbedding() == SharedEmbedding(Embedding()));
  EXPECT_FALSE(SharedEmbedding() == SharedEmbedding(makeEmbedding(0, 0)));
}

TEST(SharedEmbedding, SharesItsValuesWithItsCopies) {
  const SharedEmbedding one(makeEmbedding(1, 2));
  SharedEmbedding copy = one;
  EXPECT_EQ(copy->data(), one->data());
  copy = makeEmbedding(3, 4);
  EXPECT_EQ(*one, makeEmbedding(1, 2));
  EXPECT_EQ(*copy, makeEmbedding(3, 4));
}

TEST(SharedEmbedding, HasADirectionIfItIsFiniteAndNotZero) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(SharedEmbedding(makeEmbedding(0, 1e-30F)).hasDirection());
  EXPECT_FALSE(SharedEmbedding().hasDirection());
  EXPECT_FALSE(SharedEmbedding(makeEmbedding(0, 0)).hasDirection());
  EXPECT_FALSE(SharedEmbedding(makeEmbedding(1, nan)).hasDirection());
  EXPECT_FALSE(SharedEmbedding(makeEmbedding(1, infinity)).hasDirection());
}

TEST(SharedEmbedding, IsComparedBitForBit) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(SharedEmbedding(makeEmbedding(1, 2)) == SharedEmbedding(makeEmbedding(1, 2)));
  EXPECT_TRUE(SharedEmbedding(makeEmbedding(1, 2)) != SharedEmbedding(makeEmbedding(1, 3)));
  EXPECT_TRUE(SharedEmbedding(makeEmbedding(1, 2)) != SharedEmbedding(Embedding::Ones(3)));
  EXPECT_TRUE(SharedEmbedding(makeEmbedding(nan, 2)) == SharedEmbedding(makeEmbedding(nan, 2)));
  EXPECT_TRUE(SharedEmbedding(makeEmbedding(0, 2)) != SharedEmbedding(makeEmbedding(-0.0F, 2)));
}

}  // namespace
}  // namespace tsg
