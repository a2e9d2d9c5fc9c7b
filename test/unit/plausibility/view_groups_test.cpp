// SPDX-License-Identifier: BSD-3-Clause
#include "plausibility/view_groups.h"

#include <gtest/gtest.h>

#include <set>

#include "rgbd_walks.h"
#include "synthetic_scene.h"

namespace tsg::plausibility {
namespace {

RgbdFrame makeFrame(double x_m, double stamp_s, int width_px = 160) {
  RgbdFrame frame;
  frame.stamp = Stamp::fromSeconds(stamp_s);
  frame.camera = {width_px, 120, 131.0, 131.0, 79.5, 59.5};
  frame.T_world_camera.translation().x() = x_m;
  frame.depth.image = cv::Mat(120, width_px, CV_32FC1, cv::Scalar(2.0));
  frame.depth.metres_per_unit = 1.0;
  return frame;
}

TEST(DepthGrid, ShowsWhatItsCameraSays) {
  const CameraModel camera{640, 480, 525.0, 525.0, 319.5, 239.5};
  const auto scene = {test::makePlane({0, 0, 0}, {0, 0, 1}, {1, 1, 1})};
  const auto frame = test::render(scene, camera, test::lookAt({0, 0, 1.5}, {2, 0, 0})).frame;
  const DepthGrid grid = sampleDepth(frame, 160);
  EXPECT_EQ(grid.camera.width_px, 160);
  EXPECT_EQ(grid.camera.height_px, 120);
  for (const PixelDepth& pixel : pickPixels(grid, 100)) {
    const auto u = static_cast<double>(pixel.u_px);
    const auto v = static_cast<double>(pixel.v_px);
    const auto z = static_cast<double>(pixel.z_m);
    const Eigen::Vector3d p = frame.T_world_camera * grid.camera.unproject(u, v, z);
    EXPECT_NEAR(p.z(), 0.0, 1e-4);
  }
}

TEST(DepthGrid, CoversSizesThatNoStepDivides) {
  for (const int width_px : {1, 159, 160, 161, 321, 1279}) {
    RgbdFrame frame = makeFrame(0.0, 0.0, width_px);
    const DepthGrid grid = sampleDepth(frame, 160);
    EXPECT_LE(grid.camera.width_px, 160);
    EXPECT_GE(grid.camera.width_px, std::min(width_px, 80));
    EXPECT_EQ(grid.z_m.size(), static_cast<std::size_t>(grid.camera.width_px) *
                                   static_cast<std::size_t>(grid.camera.height_px));
  }
}

TEST(DepthGrid, PicksAboutAsManyPixelsAsAsked) {
  const auto pixels = pickPixels(sampleDepth(makeFrame(0.0, 0.0), 160), 400);
  EXPECT_GT(pixels.size(), 300U);
  EXPECT_LT(pixels.size(), 600U);
}

TEST(ViewGroups, ACameraThatStandsStillMakesNoPair) {
  ViewGroups groups;
  for (int i = 0; i < 100; ++i) groups.add(makeFrame(0.001 * (i % 3), 0.1 * i));
  for (const ViewGroup& group : groups.groups()) EXPECT_TRUE(group.targets.empty());
}

TEST(ViewGroups, ViewsAreTakenAtDoublingDistancesAndTheLastThreeKept) {
  ViewGroups groups;
  for (int i = 0; i <= 32; ++i) groups.add(makeFrame(0.0101 * i, 0.1 * i));
  ASSERT_EQ(groups.groups().size(), 1U);
  const ViewGroup& group = groups.groups().front();
  ASSERT_EQ(group.targets.size(), 3U);
  EXPECT_NEAR(group.targets[0].pose.T_world_camera.translation().x(), 0.08, 0.012);
  EXPECT_NEAR(group.targets[1].pose.T_world_camera.translation().x(), 0.16, 0.012);
  EXPECT_NEAR(group.targets[2].pose.T_world_camera.translation().x(), 0.32, 0.012);
  EXPECT_EQ(group.level, 4);
}

TEST(ViewGroups, StayBoundedAndSpreadOverTheWholeStream) {
  ViewGroups groups;
  for (int i = 0; i < 5000; ++i) groups.add(makeFrame(0.05 * i, 0.1 * i));
  EXPECT_LE(groups.groups().size(), ViewGroups::kMaxGroups);
  EXPECT_GE(groups.groups().size(), ViewGroups::kMaxGroups / 2);
  EXPECT_LT(groups.groups().front().source_pose.stamp.seconds(), 100.0);
  EXPECT_GT(groups.groups().back().source_pose.stamp.seconds(), 400.0);
  std::set<std::uint64_t> ids;
  for (const ViewGroup& group : groups.groups()) {
    EXPECT_TRUE(ids.insert(group.id).second);
    EXPECT_LE(group.targets.size(), 3U);
    EXPECT_LT(group.poses.size(), 300U);
  }
}

TEST(ViewGroups, NoGroupReachesOverAStampThatGoesBack) {
  ViewGroups groups;
  groups.add(makeFrame(0.0, 10.0));
  groups.add(makeFrame(0.05, 10.1));
  groups.add(makeFrame(0.5, 3.0));
  groups.add(makeFrame(0.9, 3.1));
  ASSERT_EQ(groups.groups().size(), 2U);
  for (const ViewGroup& group : groups.groups()) {
    for (const SampledView& view : group.targets) {
      EXPECT_LT(secondsBetween(group.source_pose.stamp, view.pose.stamp), 0.2);
      EXPECT_GT(secondsBetween(group.source_pose.stamp, view.pose.stamp), 0.0);
    }
  }
}

TEST(ViewGroups, NoGroupHoldsTwoCameras) {
  ViewGroups groups;
  groups.add(makeFrame(0.0, 0.0, 160));
  groups.add(makeFrame(0.5, 0.1, 200));
  groups.add(makeFrame(1.0, 0.2, 200));
  for (const ViewGroup& group : groups.groups()) {
    for (const SampledView& view : group.targets) {
      EXPECT_EQ(view.depth.camera.width_px, computeGridCamera(group.camera, 2).width_px);
    }
  }
}

TEST(ViewGroups, PosesRoundAGroupAreInterpolated) {
  ViewGroups groups;
  for (int i = 0; i < 40; ++i) groups.add(makeFrame(0.02 * i, 0.1 * i));
  const ViewGroup& group = groups.groups().front();
  const auto between = group.findPose(Stamp::fromSeconds(0.25));
  ASSERT_TRUE(between.has_value());
  EXPECT_NEAR(between->translation().x(), 0.05, 1e-9);
  EXPECT_TRUE(group.findPose(Stamp::fromSeconds(2.0)).has_value());  // 0.4 s after the last view
  EXPECT_FALSE(group.findPose(Stamp::fromSeconds(-0.1)).has_value());
  EXPECT_FALSE(group.findPose(Stamp::fromSeconds(9.0)).has_value());
}

}  // namespace
}  // namespace tsg::plausibility
