// SPDX-License-Identifier: BSD-3-Clause
#include "bottleneck/information.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "bottleneck_reference.h"

namespace tsg::bottleneck {
namespace {

TEST(ExactSum, DoesNotDependOnTheOrderOfAdditionsAndRemovals) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0.0, 5.0);
  std::vector<double> values(10000);
  for (double& value : values) value = uniform(random);
  ExactSum forward;
  ExactSum shuffled;
  for (const double value : values) forward.add(value);
  for (int i = 0; i < 100; ++i) shuffled.add(0.1 * i);
  std::shuffle(values.begin(), values.end(), random);
  for (const double value : values) shuffled.add(value);
  for (int i = 99; i >= 0; --i) shuffled.subtract(0.1 * i);
  EXPECT_EQ(forward.value(), shuffled.value());
  long double expected = 0.0L;
  for (const double value : values) expected += value;
  EXPECT_NEAR(forward.value(), static_cast<double>(expected), 1e-11);
}

// Published cases of mutual information, joint p(x) p(y|x); those of an invalid joint are left out:
// primitives and p(y|x) always make a valid one.
TEST(InformationSum, PublishedMutualInformation) {
  InformationSum sum;
  sum.add({{0, 1.0}});
  sum.add({{1, 1.0}});
  EXPECT_NEAR(sum.computeTotalBits(Prior::kUniform, 1) / 2.0, 1.0, 1e-15);
  EXPECT_NEAR(sum.computeTotalBits(Prior::kMarginal, 1) / 2.0, 1.0, 1e-15);
  sum.clear();
  sum.add({{0, 0.5}, {1, 0.5}});
  sum.add({{0, 0.5}, {1, 0.5}});
  EXPECT_NEAR(sum.computeTotalBits(Prior::kUniform, 1), 0.0, 1e-15);
  EXPECT_NEAR(sum.computeTotalBits(Prior::kMarginal, 1), 0.0, 1e-15);
}

TEST(InformationSum, EqualsTheDoubleSumOfTheDefinition) {
  test::SceneOptions options;
  const test::ReferenceScene scene = test::SceneGenerator(options, 3).makeScene();
  const Eigen::MatrixXd p = test::computeDenseRelevance(scene, {});
  InformationSum sum;
  for (Eigen::Index x = 0; x < p.cols(); ++x) {
    SparseMasses sparse;
    for (Eigen::Index y = 0; y < p.rows(); ++y) {
      if (p(y, x) > 0.0) sparse.push_back({static_cast<std::uint32_t>(y), p(y, x)});
    }
    sum.add(sparse);
  }
  const auto n = static_cast<double>(p.cols());
  const Eigen::VectorXd p_x = Eigen::VectorXd::Constant(p.cols(), 1.0 / n);
  const Eigen::VectorXd uniform = Eigen::VectorXd::Constant(6, 1.0 / 6.0);
  EXPECT_NEAR(sum.computeTotalBits(Prior::kUniform, 5) / n,
              test::computeDenseInformation(p_x, p, uniform), 1e-12);
  EXPECT_NEAR(sum.computeTotalBits(Prior::kMarginal, 5) / n,
              test::computeDenseInformation(p_x, p, p * p_x), 1e-12);
}

TEST(MergeRule, LimitIsTheSmallestCostThatIsNotAccepted) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> exponent(-9.0, 0.0);
  for (int i = 0; i < 1000; ++i) {
    ClusteringConfig config;
    config.delta = std::pow(10.0, exponent(random));
    const MergeRule rule(config, 1.0 + 1e5 * static_cast<double>(random() % 100));
    EXPECT_LT(rule.computeDelta(rule.limit() - 1), config.delta);
    EXPECT_TRUE(rule.limit() == 1 || rule.computeDelta(rule.limit()) >= config.delta);
  }
}

TEST(MergeRule, ZeroAcceptsNothingAndOneEverything) {
  ClusteringConfig config;
  config.delta = 0.0;
  EXPECT_FALSE(MergeRule(config, 10.0).isAccepted(0));
  config.delta = 1.0;
  EXPECT_TRUE(MergeRule(config, 10.0).isAccepted(10'000'000'000));
  config.delta = 1e-5;
  EXPECT_TRUE(MergeRule(config, 10.0).isAccepted(0));
  EXPECT_TRUE(MergeRule(config, 0.0).isAccepted(0));
}

TEST(MergeRule, SizeInvariantDeltaIsTheDivergenceOfTwoLonePrimitives) {
  ClusteringConfig config;
  config.normaliser = Normaliser::kSizeInvariant;
  const std::int64_t cost = roundCost(computeMergeCost({{1, 1.0}}, 1, {{2, 1.0}}, 1));
  EXPECT_NEAR(MergeRule(config, 1.0).computeDelta(cost), 1.0, 1e-12);
  EXPECT_EQ(MergeRule(config, 1.0).limit(), MergeRule(config, 1e6).limit());
}

}  // namespace
}  // namespace tsg::bottleneck
