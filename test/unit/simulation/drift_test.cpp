// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/drift.h"

#include <gtest/gtest.h>

#include <cmath>

#include "task_scene_graph/config/config.h"

namespace tsg::simulation {
namespace {

std::vector<WalkPose> makeStraightWalk(int num_steps, double step_m) {
  std::vector<WalkPose> walk;
  for (int i = 0; i <= num_steps; ++i) {
    walk.push_back({{i * 100000000LL}, makeCameraPose({i * step_m, 2.0, 1.4}, 0.0, 0.3)});
  }
  return walk;
}

Pose computeError(const WalkPose& truth, const WalkPose& odometry) {
  return truth.T_world_camera.inverse() * odometry.T_world_camera;
}

double angleOf(const Pose& motion) {
  return Eigen::AngleAxisd(Eigen::Quaterniond(motion.linear())).angle();
}

/// Root mean squares of position [m] and angle [rad] at the end, over 200 seeds.
Eigen::Vector2d measureDrift(const std::vector<WalkPose>& walk, DriftConfig config) {
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();
  for (config.seed = 0; config.seed < 200; ++config.seed) {
    const Pose error = computeError(walk.back(), simulateDrift(walk, config).back());
    squares += Eigen::Vector2d(error.translation().squaredNorm(), std::pow(angleOf(error), 2));
  }
  return (squares / 200.0).cwiseSqrt();
}

TEST(Drift, IsAsLargeAsSaidAfterTenMetresHoweverManyStepsThatAre) {
  for (const double systematic : {0.0, 0.5, 1.0}) {
    for (const int num_steps : {50, 400}) {
      DriftConfig config;
      config.systematic_share = systematic;
      config.angle_rad_per_m = 0.0;
      const auto walk = makeStraightWalk(num_steps, 10.0 / num_steps);
      EXPECT_NEAR(measureDrift(walk, config)(0), 0.2, 0.025) << systematic << " " << num_steps;
      config.angle_rad_per_m = 0.0017453292519943296;
      config.tilt_share = 0.0;
      EXPECT_NEAR(measureDrift(walk, config)(1), kPi / 180.0, 0.12 * kPi / 180.0) << systematic;
    }
  }
}

TEST(Drift, GrowsWithTheWayWhereSystematicAndWithItsRootWhereRandom) {
  DriftConfig config;
  config.angle_rad_per_m = 0.0;
  const auto ten = makeStraightWalk(100, 0.1);
  const auto forty = makeStraightWalk(400, 0.1);
  for (const auto& [systematic, ratio] : {std::pair{1.0, 4.0}, std::pair{0.0, 2.0}}) {
    config.systematic_share = systematic;
    EXPECT_NEAR(measureDrift(forty, config)(0) / measureDrift(ten, config)(0), ratio, 0.3);
  }
}

// A circle's arc in closed form: constant curvature, no other error.
TEST(Drift, OfConstantCurvatureBendsAStraightLineToAnArc) {
  DriftConfig config;
  config.position_per_m = 0.0;
  config.systematic_share = 1.0;
  const auto walk = makeStraightWalk(4000, 0.01);
  const auto odometry = simulateDrift(walk, config);
  const double angle_rad = 40.0 * config.angle_rad_per_m;
  const double radius_m = 1.0 / config.angle_rad_per_m;
  const Eigen::Vector3d end_m = odometry.back().T_world_camera.translation();
  EXPECT_NEAR(end_m.x(), radius_m * std::sin(angle_rad), 1e-3);
  EXPECT_NEAR(std::abs(end_m.y() - 2.0), radius_m * (1.0 - std::cos(angle_rad)), 1e-3);
  EXPECT_NEAR(end_m.z(), 1.4, 1e-9);
}

TEST(Drift, KeepsStampsFirstPoseAndPosesRigidAndFollowsFromItsSeed) {
  const auto walk = makeStraightWalk(300, 0.1);
  DriftConfig config;
  const auto odometry = simulateDrift(walk, config);
  ASSERT_EQ(odometry.size(), walk.size());
  EXPECT_EQ(odometry[0].T_world_camera.matrix(), walk[0].T_world_camera.matrix());
  for (std::size_t i = 0; i < walk.size(); ++i) {
    EXPECT_EQ(odometry[i].stamp, walk[i].stamp);
    const Eigen::Matrix3d R = odometry[i].T_world_camera.linear();
    EXPECT_TRUE((R * R.transpose()).isIdentity(1e-12));
  }
  const auto again = simulateDrift(walk, config);
  EXPECT_EQ(again.back().T_world_camera.matrix(), odometry.back().T_world_camera.matrix());
  config.seed = 2;
  const auto other = simulateDrift(walk, config);
  EXPECT_NE(other.back().T_world_camera.matrix(), odometry.back().T_world_camera.matrix());
}

TEST(Drift, OfZeroIsTheWalk) {
  const auto walk = makeStraightWalk(100, 0.1);
  DriftConfig config;
  config.position_per_m = config.angle_rad_per_m = 0.0;
  const auto odometry = simulateDrift(walk, config);
  EXPECT_TRUE(odometry.back().T_world_camera.isApprox(walk.back().T_world_camera, 1e-12));
  EXPECT_TRUE(simulateDrift({}, config).empty());
}

TEST(Drift, OutOfRangeIsRejected) {
  DriftConfig config;
  config.position_per_m = -0.1;
  EXPECT_THROW(simulateDrift({}, config), config::ConfigError);
}

}  // namespace
}  // namespace tsg::simulation
