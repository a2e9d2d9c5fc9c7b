// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/walk.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/simulation/world.h"

namespace tsg::simulation {
namespace {

double yawOf(const Pose& T) { return std::atan2(T.linear()(1, 2), T.linear()(0, 2)); }

/// Distance in the plane from a point to a box that reaches into the height range of a body.
double distanceToBox(const Aabb& box, const Eigen::Vector2d& p_m) {
  const Rect footprint(box.min().head<2>(), box.max().head<2>());
  return footprint.exteriorDistance(p_m);
}

class Walks : public ::testing::TestWithParam<std::pair<int, int>> {
 protected:
  Apartment apartment_ = buildApartment({GetParam().first, GetParam().second});
  WalkConfig config_;
  std::vector<WalkPose> walk_ = planWalk(apartment_, config_);
};

TEST_P(Walks, KeepTheBodyRadiusFromEverythingAtBodyHeight) {
  for (const Solid& solid : apartment_.solids) {
    const Aabb box = computeBounds(solid);
    if (box.max().z() <= 0.05 || box.min().z() >= 1.75) continue;
    for (const WalkPose& pose : walk_) {
      const Eigen::Vector2d p = pose.T_world_camera.translation().head<2>();
      ASSERT_GE(distanceToBox(box, p), config_.body_radius_m - 0.05) << p.transpose();
    }
  }
}

TEST_P(Walks, EnterEveryRoom) {
  std::set<int> visited;
  for (const WalkPose& pose : walk_) {
    visited.insert(apartment_.findRoom(Eigen::Vector3d(pose.T_world_camera.translation())));
  }
  for (const Room& room : apartment_.rooms) EXPECT_EQ(visited.count(room.id), 1U) << room.phrase;
}

TEST_P(Walks, BoundSpeedAndTurnRateAndKeepHeightAndRate) {
  for (std::size_t i = 0; i < walk_.size(); ++i) {
    const Pose& T = walk_[i].T_world_camera;
    EXPECT_EQ(walk_[i].stamp.ns, static_cast<std::int64_t>(i) * 100000000);
    EXPECT_NEAR(T.translation().z(), config_.camera_height_m, 1e-9);
    EXPECT_TRUE((T.linear() * T.linear().transpose()).isIdentity(1e-9));
    EXPECT_NEAR(T.linear().determinant(), 1.0, 1e-9);
    EXPECT_NEAR(T.linear()(2, 2), -std::sin(config_.pitch_down_rad), 1e-9);
    if (i == 0) continue;
    const Pose& before = walk_[i - 1].T_world_camera;
    const double step_m = (T.translation() - before.translation()).norm();
    EXPECT_LE(step_m, config_.max_speed_m_per_s * 0.1 + 0.011);
    const double turn = std::remainder(yawOf(T) - yawOf(before), 2.0 * kPi);
    EXPECT_LE(std::abs(turn), config_.max_turn_rad_per_s * 0.1 + 0.005);
  }
}

INSTANTIATE_TEST_SUITE_P(SeedsAndSizes, Walks,
                         ::testing::Values(std::pair(1, 6), std::pair(2, 3), std::pair(3, 8),
                                           std::pair(7, 6)));

TEST(Walk, TheDefaultOneIsOfReasonableLength) {
  for (int seed = 1; seed <= 8; ++seed) {
    const auto walk = planWalk(buildApartment({seed, 6}), WalkConfig{});
    EXPECT_GT(walk.size(), 400U) << seed;
    EXPECT_LT(walk.size(), 1300U) << seed;
  }
}

TEST(Walk, EndsAfterTheAskedDuration) {
  WalkConfig config;
  config.duration_s = 12.0;
  config.rate_hz = 5.0;
  const auto walk = planWalk(buildApartment({1, 6}), config);
  EXPECT_NEAR(static_cast<double>(walk.size()), 61.0, 1.0);
}

TEST(Walk, FollowsFromItsInput) {
  const Apartment apartment = buildApartment({2, 6});
  const auto a = planWalk(apartment, WalkConfig{});
  const auto b = planWalk(apartment, WalkConfig{});
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].T_world_camera.matrix(), b[i].T_world_camera.matrix());
  }
}

TEST(Walk, RefusesABodyThatDoesNotFitThroughDoors) {
  WalkConfig config;
  config.body_radius_m = 0.5;
  EXPECT_THROW(planWalk(buildApartment({1, 3}), config), config::ConfigError);
}

TEST(Walk, CameraLooksWhereYawAndPitchSay) {
  const Pose T = makeCameraPose({1.0, 2.0, 3.0}, 0.5 * kPi, 0.1);
  const Eigen::Vector3d forward(0.0, std::cos(0.1), -std::sin(0.1));
  EXPECT_TRUE(T.linear().col(2).isApprox(forward, 1e-12));
  EXPECT_TRUE(T.linear().col(0).isApprox(Eigen::Vector3d::UnitX(), 1e-12));
  EXPECT_LT(T.linear()(2, 1), 0.0);
}

TEST(FloorMap, PathsKeepTheirClearanceAndReachTheirGoal) {
  const Apartment apartment = buildApartment({1, 6});
  const FloorMap map(apartment);
  const Eigen::Vector2d from = apartment.rooms[0].interior_m.center();
  for (const auto& points : findViewpoints(apartment, map, 0.33)) {
    for (const Eigen::Vector2d& to : points) {
      const auto path = map.findPath(from, to, 0.33);
      ASSERT_GE(path.size(), 2U);
      EXPECT_EQ(path.front(), from);
      EXPECT_EQ(path.back(), to);
      for (std::size_t i = 1; i < path.size(); ++i) {
        EXPECT_GE(map.computeClearance(path[i]), 0.33);
        EXPECT_LE((path[i] - path[i - 1]).norm(), 2.1 * map.cellSize());
      }
    }
  }
  EXPECT_TRUE(map.findPath(from, from + Eigen::Vector2d(0.0, 100.0), 0.33).empty());
}

TEST(Walk, SecondLapGoesBackToTheStartAndRepeatsTheFirst) {
  const Apartment apartment = buildApartment({3, 5});
  WalkConfig config;
  const auto once = planWalk(apartment, config);
  config.laps = 2;
  const auto twice = planWalk(apartment, config);
  ASSERT_GT(twice.size(), 2 * once.size());
  for (std::size_t i = 0; i + 20 < once.size(); ++i) {  // the last leg ends without braking
    EXPECT_EQ(twice[i].T_world_camera.matrix(), once[i].T_world_camera.matrix()) << i;
  }
  std::set<int> visited;
  for (std::size_t i = once.size(); i < twice.size(); ++i) {
    visited.insert(apartment.findRoom(Eigen::Vector3d(twice[i].T_world_camera.translation())));
  }
  for (const Room& room : apartment.rooms) EXPECT_EQ(visited.count(room.id), 1U) << room.phrase;
}

TEST(Walk, OfTwoLapsOverStairsIsRejected) {
  WalkConfig config;
  config.laps = 2;
  const Apartment building = buildWorld(WorldKind::kBuilding, {});
  EXPECT_THROW(planWalk(building, config), std::invalid_argument);
}

}  // namespace
}  // namespace tsg::simulation
