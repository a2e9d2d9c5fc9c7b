// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/pipeline/background_fusion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

namespace tsg::pipeline {
namespace {

/// A panel at 1 m before a wall at 3 m; the readings of one column hang in the air at 2 m.
RgbdFrame makeMixedFrame(double seconds) {
  RgbdFrame frame;
  frame.stamp = Stamp::fromSeconds(seconds);
  frame.camera = {160, 120, 131.0, 131.0, 79.5, 59.5};
  frame.color.image = cv::Mat(120, 160, CV_8UC3, cv::Scalar(10, 20, 30));
  frame.depth.image = cv::Mat(120, 160, CV_16UC1, cv::Scalar(3000));
  frame.depth.image.colRange(0, 80).setTo(1000);
  frame.depth.image.col(80).setTo(2000);
  return frame;
}

std::ptrdiff_t countCrumbs(const BackgroundFusionConfig& config) {
  BackgroundFusion fusion(config);
  for (int i = 0; i < 5; ++i) fusion.integrate(makeMixedFrame(0.1 * i));
  const Mesh mesh = fusion.extractMesh();
  EXPECT_GT(mesh.vertices.size(), 500U);
  return std::count_if(mesh.vertices.begin(), mesh.vertices.end(),
                       [](const Eigen::Vector3f& p) { return p.z() > 1.7F && p.z() < 2.3F; });
}

TEST(BackgroundFusion, FlyingPixelsLeaveNoCrumbsInTheMesh) {
  BackgroundFusionConfig config;
  config.background.tsdf.voxel_size_m = 0.02;
  config.background.tsdf.truncation_m = 0.08;
  EXPECT_EQ(countCrumbs(config), 0);
  config.depth_filter.reject_flying_pixels = false;
  EXPECT_GT(countCrumbs(config), 10);
}

TEST(BackgroundFusion, CountsWhatTheFilterRejects) {
  BackgroundFusion fusion({});
  fusion.integrate(makeMixedFrame(0.0));
  EXPECT_EQ(fusion.depthFilterCounters().rejected_readings, 120U);
  EXPECT_EQ(fusion.depthFilterCounters().valid_readings, 120U * 160U);
}

TEST(BackgroundFusion, FramesThatDoNotFitTheirCameraAreRejected) {
  BackgroundFusion fusion({});
  RgbdFrame frame = makeMixedFrame(0.0);
  frame.camera.width_px = 80;
  EXPECT_THROW(fusion.integrate(frame), std::invalid_argument);
  EXPECT_TRUE(fusion.background().volume().blocks().empty());
}

TEST(BackgroundFusion, PlacesAreDueAfterAPeriodAndWhenStampsHaveJumpedBack) {
  BackgroundFusionConfig config;
  config.places_period_s = 1.0;
  BackgroundFusion fusion(config);
  EXPECT_NE(fusion.updatePlaces(Stamp::fromSeconds(100.0), false), nullptr);
  EXPECT_EQ(fusion.updatePlaces(Stamp::fromSeconds(100.5), false), nullptr);
  EXPECT_NE(fusion.updatePlaces(Stamp::fromSeconds(100.5), true), nullptr);
  EXPECT_NE(fusion.updatePlaces(Stamp::fromSeconds(101.5), false), nullptr);
  EXPECT_NE(fusion.updatePlaces(Stamp::fromSeconds(3.0), false), nullptr);
  EXPECT_EQ(fusion.updatePlaces(Stamp::fromSeconds(3.5), false), nullptr);
}

}  // namespace
}  // namespace tsg::pipeline
