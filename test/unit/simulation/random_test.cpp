// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tsg::simulation {
namespace {

// SplitMix64's published first output for state 0, and FNV-1a's published hash of "a" and "foobar".
TEST(Random, HashesAreThePublishedFunctions) {
  EXPECT_EQ(mixBits(0), 0xe220a8397b1dcdafULL);
  EXPECT_EQ(hashText("a"), mixBits(0xaf63dc4c8601ec8cULL));
  EXPECT_EQ(hashText("foobar"), mixBits(0x85944171f73967e8ULL));
}

TEST(Random, NumbersFollowFromTheStandardsEngineBitByBit) {
  std::mt19937_64 engine(mixBits(7));
  Random random(7);
  for (int i = 0; i < 100; ++i) {
    const double expected = std::ldexp(static_cast<double>(engine() >> 11), -53);
    EXPECT_EQ(random.uniform(), expected);
  }
}

TEST(Random, UniformNumbersAndIntegersStayInTheirRangeAndReachAllOfIt) {
  Random random(3);
  int seen[5] = {0, 0, 0, 0, 0};
  for (int i = 0; i < 2000; ++i) {
    const double x = random.uniform(-2.0, 3.0);
    EXPECT_GE(x, -2.0);
    EXPECT_LT(x, 3.0);
    ++seen[random.integer(5)];
  }
  for (const int count : seen) EXPECT_NEAR(count, 400, 80);
}

template <typename Draw>
void expectStandardNormal(const Draw& draw) {
  double sum = 0.0;
  double squares = 0.0;
  int within_one = 0;
  constexpr int kCount = 100000;
  for (int i = 0; i < kCount; ++i) {
    const double x = draw(i);
    sum += x;
    squares += x * x;
    within_one += std::abs(x) < 1.0 ? 1 : 0;
  }
  EXPECT_NEAR(sum / kCount, 0.0, 0.015);
  EXPECT_NEAR(squares / kCount, 1.0, 0.02);
  EXPECT_NEAR(within_one / static_cast<double>(kCount), 0.6827, 0.02);
}

TEST(Random, NormalNumbersHaveMeanZeroAndVarianceOne) {
  Random random(5);
  expectStandardNormal([&](int) { return random.normal(); });
  expectStandardNormal([](int i) { return toNormal(mixBits(static_cast<std::uint64_t>(i))); });
}

TEST(Random, ForksOfDifferentNamesDiffer) {
  Random a(1);
  Random b(1);
  EXPECT_NE(a.fork("kitchen").uniform(), b.fork("office").uniform());
}

}  // namespace
}  // namespace tsg::simulation
