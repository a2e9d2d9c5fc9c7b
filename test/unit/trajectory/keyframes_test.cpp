// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/trajectory/keyframes.h"

#include <gtest/gtest.h>

#include <limits>

#include "graph_worlds.h"
#include "task_scene_graph/config/config.h"

namespace tsg::trajectory {
namespace {

Keyframes makeStraight(int num) {
  Keyframes keyframes("world");
  for (int i = 0; i < num; ++i) keyframes.add({i * 1000}, makePose(0.5 * i, 0.0, 0.0));
  return keyframes;
}

TEST(Keyframes, AreAsFarOrAsTurnedFromTheOneBeforeAsTheThresholdsSay) {
  KeyframeConfig config;
  config.distance_m = 1.0;
  config.angle_rad = 0.5;
  Keyframes keyframes("world", config);
  std::vector<int> chosen;
  for (int i = 0; i < 100; ++i) {
    // 0.3 m a step for 50 steps, then a turn of 0.2 rad a step.
    const Pose pose = makePose(0.3 * std::min(i, 50), 0.0, 0.0, 0.2 * std::max(0, i - 50));
    if (keyframes.add({i}, pose)) chosen.push_back(i);
  }
  ASSERT_EQ(chosen.size(), keyframes.list().size());
  for (std::size_t k = 1; k < chosen.size(); ++k) {
    const int steps = chosen[k] - chosen[k - 1];
    EXPECT_TRUE(chosen[k] <= 50 ? steps == 4 : steps <= 5) << chosen[k];
    EXPECT_TRUE(chosen[k - 1] < 50 || steps == 3) << chosen[k];
  }
  EXPECT_EQ(keyframes.list().back().id.value, chosen.size());
  EXPECT_EQ(keyframes.find(KeyframeId{3})->stamp.ns, chosen[2]);
  EXPECT_EQ(keyframes.find(KeyframeId{1000}), nullptr);
}

TEST(Keyframes, WhatIsSeenBetweenTwoHangsOnBothByTime) {
  const Keyframes keyframes = makeStraight(4);
  EXPECT_EQ(keyframes.anchorsAt({1250}), (Anchors{{KeyframeId{2}, 0.75}, {KeyframeId{3}, 0.25}}));
  EXPECT_EQ(keyframes.anchorsAt({2000}), (Anchors{{KeyframeId{3}, 1.0}}));
  EXPECT_EQ(keyframes.anchorsAt({-5}), (Anchors{{KeyframeId{1}, 1.0}}));
  EXPECT_EQ(keyframes.anchorsAt({99999}), (Anchors{{KeyframeId{4}, 1.0}}));
}

TEST(Keyframes, StampsThatDoNotAscendAndPosesThatAreNoneAreRejected) {
  Keyframes keyframes = makeStraight(3);
  EXPECT_THROW(keyframes.add({2000}, makePose(9.0, 0.0, 0.0)), std::invalid_argument);
  EXPECT_THROW(keyframes.add({100}, makePose(9.0, 0.0, 0.0)), std::invalid_argument);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(keyframes.add({5000}, makePose(nan, 0.0, 0.0)), std::invalid_argument);
  EXPECT_EQ(keyframes.list().size(), 3U);
  EXPECT_THROW(keyframes.withPoses({Pose::Identity()}), std::invalid_argument);
  KeyframeConfig config;
  config.distance_m = 0.0;
  EXPECT_THROW(Keyframes("world", config), config::ConfigError);
}

TEST(Keyframes, TheirPoseGraphHasTheirPosesAndDriftsAsItIsTold) {
  const Keyframes keyframes = makeStraight(9);
  OdometryNoise noise;
  noise.position_m = 0.1;
  noise.angle_rad = 0.02;
  const PoseGraph graph = makePoseGraph(keyframes, noise);
  ASSERT_EQ(graph.keyframes().size(), 9U);
  ASSERT_EQ(graph.edges().size(), 8U);
  double variance = 0.0;
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_TRUE(
        graph.keyframes()[i].T_world_keyframe.isApprox(keyframes.list()[i].T_world_camera, 1e-12));
    if (i < 8) variance += 1.0 / graph.edges()[i].information(1, 1);
  }
  EXPECT_NEAR(variance, 4.0 * 0.01, 1e-12);  // after 4 m
  EXPECT_NEAR(graph.edges()[0].information(5, 5), 1.0 / (0.5 * 0.0004), 1e-9);
}

TEST(Keyframes, OfATrajectoryAreThoseOfItsPoses) {
  Trajectory trajectory;
  for (int i = 0; i < 20; ++i) trajectory.add({i}, makePose(0.25 * i, 0.0, 0.0));
  const Keyframes keyframes = selectKeyframes(trajectory, "map");
  EXPECT_EQ(keyframes.frame(), "map");
  EXPECT_EQ(keyframes.list().size(), 10U);
}

}  // namespace
}  // namespace tsg::trajectory
