// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/point_index.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tsg {
namespace {

using Points = std::vector<Eigen::Vector3d>;

std::size_t findByLookingAtAll(const Points& points, const Eigen::Vector3d& query) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    if ((points[i] - query).squaredNorm() < (points[best] - query).squaredNorm()) best = i;
  }
  return best;
}

/// Random points on a grid of `step` (0: none), so that distances are often equal.
Points makePoints(std::mt19937& random, std::size_t count, double step) {
  std::uniform_real_distribution<double> coordinate(-5.0, 5.0);
  Points points(count);
  for (Eigen::Vector3d& point : points) {
    for (int k = 0; k < 3; ++k) {
      const double x = coordinate(random);
      point[k] = step > 0.0 ? step * std::round(x / step) : x;
    }
  }
  return points;
}

TEST(PointIndex, FindsWhatLookingAtAllPointsFinds) {
  std::mt19937 random(3);
  for (const std::size_t count : {1U, 2U, 7U, 300U}) {
    for (const double step : {0.0, 0.5, 2.0, 20.0}) {
      const Points points = makePoints(random, count, step);
      const PointIndex index(points);
      for (const Points& queries :
           {makePoints(random, 200, step), points, makePoints(random, 50, 0.0)}) {
        for (const Eigen::Vector3d& query : queries) {
          ASSERT_EQ(index.findNearest(query), findByLookingAtAll(points, query));
          const Eigen::Vector3d outside = 10.0 * query;
          ASSERT_EQ(index.findNearest(outside), findByLookingAtAll(points, outside));
        }
      }
    }
  }
}

TEST(PointIndex, OfEqualDistancesTheSmallestIndexIsFound) {
  const PointIndex index({{2.0, 0.0, 0.0}, {-2.0, 0.0, 0.0}, {0.0, 2.0, 0.0}, {2.0, 0.0, 0.0}});
  EXPECT_EQ(index.findNearest({0.0, 0.0, 0.0}), 0U);
  EXPECT_EQ(index.findNearest({2.0, 0.0, 0.0}), 0U);
  EXPECT_EQ(index.findNearest({-1.0, 0.0, 0.0}), 1U);
}

TEST(PointIndex, KnowsWhetherItIsEmpty) {
  EXPECT_TRUE(PointIndex({}).isEmpty());
  EXPECT_FALSE(PointIndex({{0.0, 0.0, 0.0}}).isEmpty());
}

}  // namespace
}  // namespace tsg
