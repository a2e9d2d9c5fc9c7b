// SPDX-License-Identifier: BSD-3-Clause
#include "plausibility/pose_smoothness.h"

#include <gtest/gtest.h>

#include "rgbd_faults.h"

namespace tsg::plausibility {
namespace {

/// Poses of a camera on a circle; no images.
test::RgbdWalk makePoses(int count, double rate_hz) {
  test::RgbdWalk walk(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const double t_s = i / rate_hz;
    RgbdFrame& frame = walk[static_cast<std::size_t>(i)];
    frame.stamp = Stamp::fromSeconds(t_s);
    frame.T_world_camera = Eigen::AngleAxisd(0.5 * t_s, Eigen::Vector3d::UnitY()) *
                           Eigen::Translation3d(1.0, 0.0, 0.0);
  }
  return walk;
}

PoseSmoothness judge(const test::RgbdWalk& walk) {
  PoseSmoothness smoothness;
  for (const RgbdFrame& frame : walk) smoothness.add(frame.stamp, frame.T_world_camera);
  return smoothness;
}

TEST(PoseSmoothness, ASteadyMotionIsNotRough) {
  for (const double rate_hz : {5.0, 10.0, 30.0})
    EXPECT_FALSE(judge(makePoses(100, rate_hz)).isRough());
}

TEST(PoseSmoothness, OneJumpIsNotRough) {
  test::RgbdWalk walk = makePoses(100, 10.0);
  for (std::size_t i = 50; i < 100; ++i) walk[i].T_world_camera.translation().x() += 0.5;
  EXPECT_FALSE(judge(walk).isRough());
}

TEST(PoseSmoothness, NoiseOfItsOwnInEveryPoseIsRough) {
  EXPECT_TRUE(judge(test::withPoseNoise(makePoses(100, 30.0), 0.03, 1)).isRough());
}

TEST(PoseSmoothness, NoiseOfMillimetresIsNot) {
  EXPECT_FALSE(judge(test::withPoseNoise(makePoses(100, 30.0), 0.001, 1)).isRough());
}

TEST(PoseSmoothness, PosesThatAreHeldAreRoughAndSaidToBe) {
  test::RgbdWalk walk = makePoses(100, 10.0);
  for (std::size_t i = 0; i < walk.size(); ++i) {
    walk[i].T_world_camera = walk[i / 4 * 4].T_world_camera;
  }
  const PoseSmoothness smoothness = judge(walk);
  EXPECT_TRUE(smoothness.isRough());
  const Finding finding = describeRoughness(smoothness.computeRoughness());
  EXPECT_EQ(finding.check, "pose jitter");
  EXPECT_NE(finding.meaning.find("less often than images"), std::string::npos);
}

TEST(PoseSmoothness, FewPosesOrFarOnesSayNothing) {
  EXPECT_FALSE(judge(test::withPoseNoise(makePoses(10, 30.0), 0.1, 1)).isRough());
  EXPECT_FALSE(judge(test::withPoseNoise(makePoses(100, 1.0), 0.1, 1)).isRough());
}

}  // namespace
}  // namespace tsg::plausibility
