// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/trajectory/outside_correction.h"

#include <gtest/gtest.h>

#include "graph_worlds.h"

namespace tsg::trajectory {
namespace {

constexpr std::int64_t kTenth_ns = 100'000'000;

/// 2 cm each 0.1 s along x, and slowly round a curve.
Trajectory makeWay(int num = 300) {
  Trajectory way;
  for (int i = 0; i < num; ++i) {
    way.add({(i + 1) * kTenth_ns}, makePose(0.02 * i, 0.0, 1.5, 0.003 * i));
  }
  return way;
}

/// Drift that grows along the way.
Pose computeDrift(std::int64_t ns) {
  const double s = 1e-9 * static_cast<double>(ns);
  return makePose(0.02 * s, -0.01 * s, 0.0, 0.005 * s);
}

/// The way with the drift taken out, at every n-th pose.
Trajectory mend(const Trajectory& way, int every, const Pose& T_camera_body = Pose::Identity()) {
  Trajectory mended;
  int i = 0;
  for (const auto& [ns, pose] : way.poses()) {
    if (i++ % every == 0) mended.add({ns}, computeDrift(ns) * pose * T_camera_body);
  }
  return mended;
}

std::string findFault(const Trajectory& own, const Trajectory& corrected) {
  try {
    computeOutsideCorrection(own, own, corrected, "map");
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "no fault";
}

TEST(OutsideCorrection, TakesTheDriftOutOfAllPosesAlsoBetweenThoseThatAreGiven) {
  const Trajectory own = makeWay();
  const auto found = computeOutsideCorrection(own, own, mend(own, 10), "map");
  EXPECT_EQ(found.before.frame(), "map");
  EXPECT_GT(found.before.list().size(), 8U);
  const Trajectory moved = applyCorrection(found.correction, found.before, own);
  for (const auto& [ns, pose] : own.poses()) {
    if (ns > found.before.list().back().stamp.ns) continue;
    const Pose expected = computeDrift(ns) * pose;
    EXPECT_LT((moved.poses().at(ns).translation() - expected.translation()).norm(), 2e-4) << ns;
    EXPECT_LT((moved.poses().at(ns).linear() - expected.linear()).norm(), 2e-4) << ns;
  }
  EXPECT_NEAR(found.max_turn_rad, 0.005 * 29.1, 1e-6);
}

TEST(OutsideCorrection, WhereTheOdometryHasSlippedNothingIsMovedInBetween) {
  const Trajectory own = makeWay();
  Trajectory corrected;
  const std::int64_t slipped_ns = 157 * kTenth_ns;  // not far from a keyframe
  for (const auto& [ns, pose] : own.poses()) {
    corrected.add({ns}, ns < slipped_ns ? pose : makePose(0.3, 0.1, 0.0) * pose);
  }
  const auto found = computeOutsideCorrection(own, own, corrected, "map");
  const Trajectory moved = applyCorrection(found.correction, found.before, own);
  for (const auto& [ns, pose] : corrected.poses()) {
    EXPECT_TRUE(moved.poses().at(ns).isApprox(pose, 1e-9)) << ns;
  }
}

TEST(OutsideCorrection, TheLastPoseIsAKeyframeHoweverNear) {
  const Trajectory own = makeWay();
  const auto found = computeOutsideCorrection(own, own, mend(own, 1), "map");
  EXPECT_EQ(found.before.list().back().stamp, own.last());
  EXPECT_TRUE(found.correction.motions().back().T_new_old.isApprox(computeDrift(own.last().ns)));
}

TEST(OutsideCorrection, PosesOfAnotherBodyGiveTheSameMotions) {
  const Trajectory own = makeWay();
  const Pose T_camera_body = makePose(0.3, -0.2, -1.0, 0.8);
  Trajectory reported;
  for (const auto& [ns, pose] : own.poses()) reported.add({ns}, pose * T_camera_body);
  const auto camera = computeOutsideCorrection(own, own, mend(own, 5), "map");
  const auto body = computeOutsideCorrection(own, reported, mend(own, 5, T_camera_body), "map");
  const Trajectory a = applyCorrection(camera.correction, camera.before, own);
  const Trajectory b = applyCorrection(body.correction, body.before, own);
  for (const auto& [ns, pose] : a.poses()) {  // which are keyframes may hang on the last bit
    EXPECT_LT((b.poses().at(ns).translation() - pose.translation()).norm(), 1e-3) << ns;
    EXPECT_LT((b.poses().at(ns).linear() - pose.linear()).norm(), 1e-3) << ns;
  }
}

TEST(OutsideCorrection, TheSamePosesAreTheIdentityAlsoAfterRounding) {
  const Trajectory own = makeWay();
  EXPECT_TRUE(computeOutsideCorrection(own, own, own, "map").correction.isIdentity());
  Trajectory rounded;
  for (const auto& [ns, pose] : own.poses()) {
    Pose other = pose;
    other.linear() = Eigen::Quaterniond(pose.linear()).normalized().toRotationMatrix();
    rounded.add({ns}, other);
  }
  EXPECT_TRUE(computeOutsideCorrection(own, own, rounded, "map").correction.isIdentity());
}

TEST(OutsideCorrection, PosesOutsideTheWayAndInItsGapsArePassedOver) {
  Trajectory own;
  const Trajectory whole = makeWay();
  for (const auto& [ns, pose] : whole.poses()) {
    const bool is_paused = ns > 100 * kTenth_ns && ns < 200 * kTenth_ns;
    if (!is_paused && ns > 20 * kTenth_ns) own.add({ns}, pose);
  }
  const auto found = computeOutsideCorrection(own, own, mend(whole, 1), "map");
  for (const Keyframe& keyframe : found.before.list()) {
    EXPECT_GT(keyframe.stamp.ns, 20 * kTenth_ns);
    EXPECT_FALSE(keyframe.stamp.ns > 100 * kTenth_ns && keyframe.stamp.ns < 200 * kTenth_ns);
  }
}

TEST(OutsideCorrection, FaultsNameWhatWasFoundAndExpected) {
  const Trajectory own = makeWay();
  EXPECT_EQ(findFault(own, {}), "the corrected trajectory has no pose, expected 2 at least");
  EXPECT_EQ(findFault({}, own), "the map has no trajectory that a corrected one could be of");
  Trajectory later;
  later.add({1000 * kTenth_ns}, Pose::Identity());
  later.add({1001 * kTenth_ns}, Pose::Identity());
  EXPECT_EQ(findFault(own, later),
            "0 of 2 poses of the corrected trajectory (100 to 100.1 s) lie within the map's (0.1 "
            "to 30 s), expected 2 at least");
  Trajectory broken = own;
  Pose nan = Pose::Identity();
  nan.translation().x() = std::nan("");
  broken.add({5 * kTenth_ns}, nan);
  EXPECT_EQ(findFault(own, broken),
            "the corrected pose at stamp 500000000 ns is not finite or no rotation");
  Trajectory far;
  for (const auto& [ns, pose] : own.poses()) far.add({ns}, makePose(0.0, 0.0, 200.0) * pose);
  EXPECT_EQ(findFault(own, far),
            "the correction moves the camera by 200 m, expected at most 50 m (max_motion_m)");
}

TEST(OutsideCorrection, AJumpOfTheFrameMovesAllAlike) {
  const Trajectory own = makeWay();
  const Pose T = makePose(1.0, 2.0, 0.0, 0.5);
  const auto found = makeOutsideCorrection(own, T, "map");
  EXPECT_TRUE(found.correction.isRigid());
  EXPECT_EQ(found.correction.at(found.before.anchorsAt({7 * kTenth_ns})).matrix(), T.matrix());
  EXPECT_THROW(makeOutsideCorrection(Trajectory(), T, "map"), std::invalid_argument);
}

}  // namespace
}  // namespace tsg::trajectory
