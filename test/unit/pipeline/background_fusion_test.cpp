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

void integrate(BackgroundFusion& fusion, const RgbdFrame& frame) {
  const RgbdFramePtr filtered = fusion.filter(frame);
  fusion.free_space.integrate(*filtered);
  fusion.surface.integrate(*filtered);
}

std::ptrdiff_t countCrumbs(const BackgroundFusionConfig& config) {
  BackgroundFusion fusion(config);
  for (int i = 0; i < 5; ++i) integrate(fusion, makeMixedFrame(0.1 * i));
  const Mesh mesh = fusion.surface.extractMesh();
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
  integrate(fusion, makeMixedFrame(0.0));
  EXPECT_EQ(fusion.depth_filter.counters().rejected_readings, 120U);
  EXPECT_EQ(fusion.depth_filter.counters().valid_readings, 120U * 160U);
}

TEST(BackgroundFusion, FramesThatDoNotFitTheirCameraAreRejected) {
  BackgroundFusion fusion({});
  RgbdFrame frame = makeMixedFrame(0.0);
  frame.camera.width_px = 80;
  EXPECT_THROW(fusion.filter(frame), std::invalid_argument);
  EXPECT_TRUE(fusion.surface.volume().blocks().empty());
}

TEST(BackgroundFusion, FilteringLeavesTheFrameAsItIs) {
  BackgroundFusion fusion({});
  const RgbdFrame frame = makeMixedFrame(0.0);
  const RgbdFramePtr filtered = fusion.filter(frame);
  EXPECT_EQ(frame.depth.image.at<std::uint16_t>(60, 80), 2000);
  EXPECT_EQ(filtered->depth.at(80, 60), 0.0F);
  EXPECT_EQ(filtered->color.image.data, frame.color.image.data);
}

}  // namespace
}  // namespace tsg::pipeline
