// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/loops/visibility.h"

#include <gtest/gtest.h>

#include "task_scene_graph/loops/scene.h"

namespace tsg::loops {
namespace {

const CameraModel kCamera{40, 30, 30.0, 30.0, 19.5, 14.5};

DepthImage makeWall(float depth_m) {
  DepthImage depth;
  depth.image = cv::Mat(30, 40, CV_32FC1, cv::Scalar(depth_m));
  depth.metres_per_unit = 1.0;
  return depth;
}

Points makePoints(float z_m) {
  Points points;
  for (int i = -5; i <= 5; ++i) {
    for (int j = -5; j <= 5; ++j) {
      points.emplace_back(0.1F * static_cast<float>(i), 0.08F * static_cast<float>(j), z_m);
    }
  }
  return points;
}

Pose makeShift(double z_m) {
  Pose T = Pose::Identity();
  T.translation().z() = z_m;
  return T;
}

TEST(DepthView, KeepsTheNearestReadingOfEachCell) {
  DepthImage depth = makeWall(4.0F);
  depth.image.at<float>(5, 9) = 1.5F;
  depth.image(cv::Rect(0, 0, 5, 4)).setTo(0.0F);  // all of the first cell
  const DepthView view = makeDepthView(depth, kCamera, 5);
  ASSERT_EQ(view.camera.width_px, 8);
  ASSERT_EQ(view.camera.height_px, 6);
  ASSERT_EQ(view.nearest_m.size(), 48U);
  EXPECT_EQ(view.nearest_m[0], 0.0F);
  EXPECT_EQ(view.nearest_m[9], 1.5F);
  EXPECT_EQ(view.nearest_m[47], 4.0F);
}

TEST(DepthView, ProjectsIntoTheCellOfThePixel) {
  const DepthView view = makeDepthView(makeWall(4.0F), kCamera, 5);
  for (int v = 0; v < 30; ++v) {
    for (int u = 0; u < 40; ++u) {
      const Eigen::Vector2d cell = view.camera.project(kCamera.unproject(u, v, 2.0));
      EXPECT_EQ(std::lround(cell.x()), u / 5);
      EXPECT_EQ(std::lround(cell.y()), v / 5);
    }
  }
}

TEST(Visibility, OfPointsOnBeforeAndBehindASurface) {
  const std::vector<DepthView> views = {makeDepthView(makeWall(3.0F), kCamera, 5)};
  const Visibility on = lookAt(makePoints(3.0F), Pose::Identity(), views, 0.1);
  EXPECT_EQ(on.num_seen, 121U);
  EXPECT_EQ(on.num_through, 0U);
  const Visibility before = lookAt(makePoints(2.0F), Pose::Identity(), views, 0.1);
  EXPECT_EQ(before.num_seen, 0U);
  EXPECT_EQ(before.num_through, 121U);
  EXPECT_EQ(before.shareThrough(), 1.0);
  const Visibility behind = lookAt(makePoints(4.0F), Pose::Identity(), views, 0.1);
  EXPECT_EQ(behind.num_seen + behind.num_through, 0U);
  EXPECT_EQ(behind.shareThrough(), 0.0);
  EXPECT_EQ((on + before).shareThrough(), 0.5);
}

TEST(Visibility, IsThatOfThePointsWhereTheyAreInTheViewsScene) {
  const std::vector<DepthView> views = {makeDepthView(makeWall(3.0F), kCamera, 5)};
  EXPECT_EQ(lookAt(makePoints(2.0F), makeShift(1.0), views, 0.1).num_seen, 121U);
  EXPECT_EQ(lookAt(makePoints(3.0F), makeShift(-1.0), views, 0.1).num_through, 121U);
}

TEST(Visibility, WhatOneViewMeasuredNoOtherLookedThrough) {
  DepthView other = makeDepthView(makeWall(5.0F), kCamera, 5);
  const std::vector<DepthView> views = {other, makeDepthView(makeWall(3.0F), kCamera, 5)};
  EXPECT_EQ(lookAt(makePoints(3.0F), Pose::Identity(), views, 0.1).num_seen, 121U);
}

TEST(Visibility, OutsideTheImagesAndWithoutReadingsIsNone) {
  const std::vector<DepthView> blind = {makeDepthView(makeWall(0.0F), kCamera, 5)};
  const Visibility unknown = lookAt(makePoints(2.0F), Pose::Identity(), blind, 0.1);
  EXPECT_EQ(unknown.num_seen + unknown.num_through, 0U);
  const std::vector<DepthView> views = {makeDepthView(makeWall(3.0F), kCamera, 5)};
  const Visibility at_the_back = lookAt(makePoints(-2.0F), Pose::Identity(), views, 0.1);
  EXPECT_EQ(at_the_back.num_seen + at_the_back.num_through, 0U);
}

TEST(Visibility, MovesWithTheScene) {
  RgbdFrame frame;
  frame.camera = kCamera;
  frame.depth = makeWall(3.0F);
  const Scene part = makeScene(frame, nullptr, {});
  ASSERT_EQ(part.views.size(), 1U);
  const Pose T = makeShift(7.0);
  const Scene joined = joinScenes({{T, &part}, {Pose::Identity(), &part}}, {}, 0.8);
  ASSERT_EQ(joined.views.size(), 2U);
  EXPECT_EQ(joined.views[0].T_scene_camera.matrix(), T.matrix());
  const Visibility own = lookAt(joined.points, Pose::Identity(), joined.views, 0.1);
  EXPECT_EQ(own.num_through, 0U);
  EXPECT_GT(own.num_seen, 0U);
}

}  // namespace
}  // namespace tsg::loops
