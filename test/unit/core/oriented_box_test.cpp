// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/oriented_box.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace tsg {
namespace {

/// Least footprint over 1800 directions of a quarter turn.
double searchLeastArea(const std::vector<Eigen::Vector3f>& points) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 1800; ++i) {
    const Eigen::Rotation2Dd turn(-M_PI_2 * i / 1800.0);
    Eigen::AlignedBox2d box;
    for (const auto& p : points) box.extend(turn * p.head<2>().cast<double>());
    least = std::min(least, box.sizes().prod());
  }
  return least;
}

std::vector<Eigen::Vector3f> makeCloud(std::mt19937& random, double yaw_rad,
                                       const Eigen::Vector3d& center, const Eigen::Vector3d& size) {
  std::uniform_real_distribution<double> unit(-0.5, 0.5);
  const Eigen::AngleAxisd turn(yaw_rad, Eigen::Vector3d::UnitZ());
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d p(unit(random), unit(random), unit(random));
    points.emplace_back((center + turn * p.cwiseProduct(size)).cast<float>());
  }
  return points;
}

TEST(OrientedBox, HoldsAllPointsAndNoTurnedBoxIsSmaller) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-5.0, 5.0);
  for (int round = 0; round < 50; ++round) {
    const auto points =
        makeCloud(random, any(random), {any(random), any(random), any(random)}, {1.5, 0.4, 0.7});
    const OrientedBox box = computeOrientedBox(points);
    for (const auto& p : points) EXPECT_TRUE(box.contains(p.cast<double>(), 1e-5));
    EXPECT_LE(box.size_m.x() * box.size_m.y(), 1.0001 * searchLeastArea(points));
    EXPECT_GE(box.yaw_rad, -M_PI_4);
    EXPECT_LT(box.yaw_rad, M_PI_4);
  }
}

TEST(OrientedBox, IsTheBoxWhoseCornersItIsGiven) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> yaw(-M_PI_4, M_PI_4);
  for (int round = 0; round < 50; ++round) {
    const OrientedBox given{{300.0, -200.0, 1.0}, {0.8, 0.3, 0.5}, yaw(random)};
    const auto corners = given.corners();
    const OrientedBox found = computeOrientedBox({corners.begin(), corners.end()});
    EXPECT_TRUE(found.center_m.isApprox(given.center_m, 1e-6));
    EXPECT_TRUE(found.size_m.isApprox(given.size_m, 1e-3));
    EXPECT_NEAR(found.yaw_rad, given.yaw_rad, 1e-3);
  }
}

TEST(OrientedBox, AlignedPointsGiveTheAlignedBox) {
  const Aabb aligned = makeAabb({-1, 2, 0}, {1, 2.5, 0.2});
  const auto corners = toOrientedBox(aligned).corners();
  const OrientedBox box = computeOrientedBox({corners.begin(), corners.end()});
  EXPECT_EQ(box.yaw_rad, 0.0);
  EXPECT_TRUE(box.center_m.isApprox(aligned.center(), 1e-6));
  EXPECT_TRUE(box.size_m.isApprox(aligned.sizes(), 1e-6));
}

TEST(OrientedBox, FewPointsGiveFlatBoxes) {
  EXPECT_TRUE(computeOrientedBox({}).isEmpty());
  EXPECT_TRUE(computeOrientedBox({{1, 2, 3}}).isEmpty());
  const OrientedBox line = computeOrientedBox({{0, 0, 0}, {0.3F, 0.4F, 0}, {0.6F, 0.8F, 0}});
  EXPECT_NEAR(line.size_m.head<2>().maxCoeff(), 1.0, 1e-6);
  EXPECT_NEAR(line.size_m.head<2>().minCoeff(), 0.0, 1e-6);
  EXPECT_TRUE(toOrientedBox(Aabb()).isEmpty());
}

}  // namespace
}  // namespace tsg
