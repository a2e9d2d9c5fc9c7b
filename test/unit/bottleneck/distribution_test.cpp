// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/bottleneck/distribution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "bottleneck_reference.h"

namespace tsg::bottleneck {
namespace {

SparseMasses toSparse(const Eigen::VectorXd& dense) {
  SparseMasses sparse;
  for (Eigen::Index y = 0; y < dense.size(); ++y) {
    if (dense[y] > 0.0) sparse.push_back({static_cast<std::uint32_t>(y), dense[y]});
  }
  return sparse;
}

Eigen::VectorXd makeRandom(std::mt19937& random, Eigen::Index size) {
  std::uniform_real_distribution<double> uniform;
  Eigen::VectorXd p(size);
  for (Eigen::Index i = 0; i < p.size(); ++i) p[i] = std::max(uniform(random) - 0.4, 0.0);
  p[0] += 0.1;
  return p / p.sum();
}

// The published cases of Jensen-Shannon divergences are of columns with weights of a probability;
// D is the same with masses in place of weights.
TEST(Distribution, PublishedEntropiesAndDivergences) {
  EXPECT_EQ(computeEntropyBits(toSparse(Eigen::Vector2d(0, 1))), 0.0);
  EXPECT_EQ(computeEntropyBits(toSparse(Eigen::Vector2d(1, 0))), 0.0);
  EXPECT_EQ(computeEntropyBits(toSparse(Eigen::Vector2d(0.5, 0.5))), 1.0);
  const auto js = [](const Eigen::VectorXd& p, const Eigen::VectorXd& q) {
    return computeMergeCost(toSparse(0.5 * p), 0.5, toSparse(0.5 * q), 0.5);
  };
  EXPECT_NEAR(js(Eigen::Vector2d(1, 0), Eigen::Vector2d(0, 1)), 1.0, 1e-15);
  EXPECT_EQ(js(Eigen::Vector2d(0.5, 0.5), Eigen::Vector2d(0.5, 0.5)), 0.0);
  EXPECT_EQ(js(Eigen::Vector2d(1, 0), Eigen::Vector2d(1, 0)), 0.0);
  EXPECT_EQ(computeMergeCost({{0, 1.0}}, 1.0, {}, 0.0), 0.0);  // all weight on one column
  EXPECT_NEAR(js(Eigen::Vector3d(3, 4, 1) / 8.0, Eigen::Vector3d(2, 3, 3) / 8.0),
              0.06272109860314778, 1e-15);
}

TEST(Distribution, PublishedDivergenceOfFiveColumnsIsTheSumOverAnyOrderOfMerges) {
  SparseMasses merged{{0, 0.2}};
  double total = 0.0;
  for (std::uint32_t i = 1; i < 5; ++i) {
    const SparseMasses next{{i, 0.2}};
    total += computeMergeCost(merged, 0.2 * i, next, 0.2);
    merged = addMasses(merged, next);
  }
  EXPECT_NEAR(total, std::log2(5.0), 1e-12);
}

TEST(Distribution, CostIsTheMassTimesTheDivergence) {
  std::mt19937 random(4);
  for (int i = 0; i < 200; ++i) {
    const Eigen::VectorXd p = makeRandom(random, 7);
    const Eigen::VectorXd q = makeRandom(random, 7);
    const double a = 1.0 + static_cast<double>(random() % 1000);
    const double b = 1.0 + static_cast<double>(random() % 10);
    Eigen::MatrixXd columns(7, 2);
    columns << p, q;
    const double divergence =
        test::computeDenseJensenShannon(columns, Eigen::Vector2d(a, b) / (a + b));
    EXPECT_NEAR(computeMergeCost(toSparse(a * p), a, toSparse(b * q), b), (a + b) * divergence,
                1e-11 * (a + b));
  }
}

TEST(Distribution, ClustersThatShareNoTaskCostTheSameWhateverTheyServe) {
  const double cost = computeMergeCost({{1, 2.0}, {3, 1.0}}, 3.0, {{2, 5.0}}, 5.0);
  EXPECT_EQ(cost, computeMergeCost({{0, 3.0}}, 3.0, {{4, 1.0}, {5, 4.0}}, 5.0));
  EXPECT_EQ(cost, computeMixingBits(3.0, 5.0));
}

TEST(Distribution, EqualDistributionsCostExactlyNothing) {
  std::mt19937 random(5);
  for (int i = 0; i < 100; ++i) {
    const SparseMasses p = toSparse(makeRandom(random, 5));
    SparseMasses sum = p;
    for (int n = 2; n < 200; ++n) {
      sum = addMasses(sum, p);
      ASSERT_EQ(computeMergeCost(sum, n, p, 1.0), 0.0) << n;
    }
  }
}

TEST(Distribution, MixingBitsKeepTheirPrecisionForUnequalMasses) {
  // h(1, n) = log2(n + 1) + n log2(1 + 1/n)
  EXPECT_NEAR(computeMixingBits(1.0, 1e12), std::log2(1e12) + 1.0 / std::log(2.0), 1e-11);
  EXPECT_EQ(computeMixingBits(0.0, 5.0), 0.0);
  EXPECT_EQ(computeMixingBits(3.0, 7.0), computeMixingBits(7.0, 3.0));
  EXPECT_NEAR(computeMixingBits(1.0, 1.0), 2.0, 1e-15);
}

TEST(Distribution, LostInformationIsSymmetricOverThreeClusters) {
  std::mt19937 random(6);
  for (int i = 0; i < 50; ++i) {
    const SparseMasses x = toSparse(makeRandom(random, 6));
    const SparseMasses y = toSparse(makeRandom(random, 6));
    const SparseMasses z = toSparse(makeRandom(random, 6));
    const double left = computeMergeCost(x, 1, y, 1) + computeMergeCost(addMasses(x, y), 2, z, 1);
    const double right = computeMergeCost(y, 1, z, 1) + computeMergeCost(addMasses(y, z), 2, x, 1);
    EXPECT_NEAR(left, right, 1e-13);
  }
}

TEST(Distribution, CostsAreRoundedToNineDecimals) {
  EXPECT_EQ(roundCost(1.0), 1000000000);
  EXPECT_EQ(roundCost(4.4e-10), 0);
  EXPECT_EQ(roundCost(6e-10), 1);
}

}  // namespace
}  // namespace tsg::bottleneck
