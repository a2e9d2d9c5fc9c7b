// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/trajectory/correction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "graph_worlds.h"

namespace tsg::trajectory {
namespace {

Keyframes makeWay(int num, std::uint32_t seed = 1) {
  Noise noise(seed);
  Keyframes keyframes("world");
  for (int i = 0; i < num; ++i) {
    keyframes.add({i * 1'000'000'000LL}, makePose(2.0 * i, 0.0, 0.0) * noise.draw(0.1, 0.5));
  }
  return keyframes;
}

/// The keyframes at poses that have drifted.
Keyframes drift(const Keyframes& keyframes, std::uint32_t seed) {
  Noise noise(seed);
  std::vector<Pose> poses;
  for (const Keyframe& keyframe : keyframes.list()) {
    poses.push_back(noise.draw(0.5, 0.2) * keyframe.T_world_camera);
  }
  return keyframes.withPoses(poses);
}

template <typename Action>
void expectRejected(const std::string& expected, const Action& action) {
  try {
    action();
    ADD_FAILURE() << "nothing was thrown, expected: " << expected;
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
  }
}

// Blending

TEST(Blend, OfMotionsThatAreAlikeIsThatMotionToTheBit) {
  Noise noise(1);
  const Pose motion = noise.draw(3.0, 1.0);
  EXPECT_EQ(blend({{motion, 0.3}, {motion, 0.3}, {motion, 0.4}}).matrix(), motion.matrix());
}

TEST(Blend, OfShiftsIsTheirMean) {
  const Pose blended = blend({{makePose(1.0, 0.0, 2.0), 0.25}, {makePose(3.0, 4.0, -2.0), 0.75}});
  EXPECT_TRUE(blended.isApprox(makePose(2.5, 3.0, -1.0), 1e-12));
}

TEST(Blend, HalfwayBetweenTwoLiesHalfOfTheScrewThatJoinsThem) {
  Noise noise(2);
  for (int i = 0; i < 50; ++i) {
    const Pose a = noise.draw(2.0, 0.6);
    const Pose b = noise.draw(2.0, 0.6);
    const Pose middle = blend({{a, 0.5}, {b, 0.5}});
    EXPECT_TRUE((a.inverse() * middle).isApprox(middle.inverse() * b, 1e-9));
    EXPECT_TRUE(isRigid(middle));
  }
}

TEST(Blend, DoesNotDependOnCoordinatesNorOnOrderNorOnTheSignOfQuaternions) {
  Noise noise(3);
  for (int i = 0; i < 50; ++i) {
    std::vector<std::pair<Pose, double>> motions;
    for (const double share : {0.1, 0.2, 0.3, 0.4})
      motions.emplace_back(noise.draw(2.0, 0.4), share);
    const Pose blended = blend(motions);
    const Pose left = noise.draw(5.0, 3.0);
    const Pose right = noise.draw(5.0, 3.0);
    auto moved = motions;
    for (auto& motion : moved) motion.first = left * motion.first * right;
    EXPECT_TRUE(blend(moved).isApprox(left * blended * right, 1e-9));
    std::reverse(motions.begin(), motions.end());
    EXPECT_TRUE(blend(motions).isApprox(blended, 1e-12));
  }
}

TEST(Blend, OfRightMotionsAndItsOwnInverseIsNearTheIdentity) {
  const Pose motion = makePose(0.1, 0.0, 0.0, 0.3);
  EXPECT_TRUE(blend({{motion, 0.5}, {motion.inverse(), 0.5}}).linear().isIdentity(1e-12));
}

// By old and new poses

TEST(Correction, BringsOldPosesToNewOnes) {
  const Keyframes before = makeWay(10);
  const Keyframes after = drift(before, 7);
  const Correction correction = computeCorrection(before, after);
  const Keyframes applied = applyCorrection(correction, before);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_TRUE(applied.list()[i].T_world_camera.isApprox(after.list()[i].T_world_camera, 1e-12));
    EXPECT_EQ(applied.list()[i].stamp, before.list()[i].stamp);
  }
  EXPECT_FALSE(correction.isIdentity());
  EXPECT_FALSE(correction.isRigid());
}

TEST(Correction, OfPosesThatStayIsTheIdentityToTheBit) {
  const Keyframes before = makeWay(10);
  EXPECT_TRUE(computeCorrection(before, before).isIdentity());
  const Keyframes after = applyCorrection(computeCorrection(before, before), before);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(after.list()[i].T_world_camera.matrix(), before.list()[i].T_world_camera.matrix());
  }
}

TEST(Correction, OfASolvedGraphMovesItsKeyframesAndLeavesTheFirst) {
  LapWorld world = makeLaps(150, 1);
  const PoseGraph before = world.graph;
  for (const PoseEdge& loop : world.loops) world.graph.addEdge(loop);
  ASSERT_EQ(world.graph.optimize().status, SolveStatus::kSolved);
  const Correction correction = computeCorrection(before, world.graph);
  EXPECT_EQ(correction.motions()[0].T_new_old.matrix(), Pose::Identity().matrix());
  for (std::size_t i = 0; i < 150; ++i) {
    EXPECT_TRUE((correction.motions()[i].T_new_old * before.keyframes()[i].T_world_keyframe)
                    .isApprox(world.graph.keyframes()[i].T_world_keyframe, 1e-12));
  }
}

TEST(Correction, ByAnotherTrajectoryTakesItsPosesAtTheKeyframesStamps) {
  const Keyframes before = makeWay(10);
  const Pose jump = makePose(1.0, 2.0, 0.0, 0.1);
  Trajectory corrected;  // twice as dense, from the third keyframe to the eighth
  for (int i = 4; i <= 14; ++i) {
    const Pose pose = i % 2 == 0 ? before.list()[static_cast<std::size_t>(i / 2)].T_world_camera
                                 : Pose::Identity();
    corrected.add({i * 500'000'000LL}, jump * pose);
  }
  const Correction correction = computeCorrection(before, corrected, "world", 1.0);
  ASSERT_EQ(correction.motions().size(), 10U);
  for (const KeyframeMotion& motion : correction.motions()) {
    EXPECT_TRUE(motion.T_new_old.isApprox(jump, 1e-12)) << motion.id.value;
  }
}

TEST(Correction, ThatDoesNotFitIsRejectedWithTheReason) {
  const Keyframes before = makeWay(5);
  expectRejected("a number of keyframes of 4, expected 5",
                 [&] { computeCorrection(before, makeWay(4)); });
  expectRejected("the frame map, expected world",
                 [&] { computeCorrection(before, Trajectory(), "map", 1.0); });
  expectRejected("no pose at the time of any keyframe",
                 [&] { computeCorrection(before, Trajectory(), "world", 1.0); });
  Trajectory sparse;
  sparse.add({0}, Pose::Identity());
  sparse.add({10'000'000'000}, Pose::Identity());
  expectRejected("a gap of 10 s at keyframe 2, expected at most 1 s",
                 [&] { computeCorrection(before, sparse, "world", 1.0); });
  Trajectory broken;
  broken.add({0}, makePose(std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0));
  expectRejected("keyframe 1 has a corrected pose that is not finite",
                 [&] { computeCorrection(before, broken, "world", 1.0); });
  expectRejected("keyframe 2 after keyframe 2", [&] {
    Correction({{KeyframeId{2}, Pose::Identity()}, {KeyframeId{2}, Pose::Identity()}});
  });
  expectRejected("does not name keyframe 5", [&] {
    makeRigidCorrection(makeWay(4), Pose::Identity()).at({{KeyframeId{5}, 1.0}});
  });
}

TEST(Correction, APoseBetweenKeyframesMovesBetweenThem) {
  const Keyframes before = makeWay(3);
  const Correction correction({{KeyframeId{1}, Pose::Identity()},
                               {KeyframeId{2}, makePose(1.0, 0.0, 0.0)},
                               {KeyframeId{3}, makePose(3.0, 0.0, 0.0)}});
  Trajectory trajectory;
  for (int i = 0; i <= 8; ++i)
    trajectory.add({i * 250'000'000LL}, makePose(0.5 * i, 1.0, 2.0, 0.3));
  const Trajectory corrected = applyCorrection(correction, before, trajectory);
  ASSERT_EQ(corrected.size(), trajectory.size());
  const double expected_m[] = {0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0};
  for (int i = 0; i <= 8; ++i) {
    const Pose& pose = corrected.poses().at(i * 250'000'000LL);
    EXPECT_NEAR(pose.translation().x(), 0.5 * i + expected_m[i], 1e-12);
    EXPECT_TRUE(pose.linear().isApprox(makePose(0.0, 0.0, 0.0, 0.3).linear()));
  }
}

}  // namespace
}  // namespace tsg::trajectory
