// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/camera_markers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "task_scene_graph/ros/geometry_conversions.h"

namespace tsg::ros_interface {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

const CameraModel kCamera{640, 480, 500.0, 500.0, 319.5, 239.5};

Pose poseAt(double x_m, double y_m, double z_m) {
  Pose pose = Pose::Identity();
  pose.translation() = Eigen::Vector3d(x_m, y_m, z_m);
  return pose;
}

std::vector<Marker> find(const MarkerArray& array, const std::string& ns) {
  std::vector<Marker> found;
  std::copy_if(array.markers.begin(), array.markers.end(), std::back_inserter(found),
               [&](const Marker& marker) { return marker.ns == ns; });
  return found;
}

TEST(CameraMarkers, TheFrustumIsWhatTheCameraSees) {
  CameraMarkers markers("map");
  Pose pose = poseAt(1.0, 2.0, 3.0);
  pose.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const auto frustum = find(markers.add(kCamera, pose), "camera_frustum");
  ASSERT_EQ(frustum.size(), 1U);
  EXPECT_EQ(frustum[0].header.frame_id, "map");
  ASSERT_EQ(frustum[0].points.size(), 16U);
  std::size_t num_centers = 0;
  for (const auto& point : frustum[0].points) {
    const Eigen::Vector3d p_camera = pose.inverse() * toVector(point);
    if (p_camera.norm() < 1e-9) {
      ++num_centers;
      continue;
    }
    EXPECT_NEAR(p_camera.z(), CameraMarkers::kFrustum_m, 1e-9);
    const Eigen::Vector2d pixel = kCamera.project(p_camera);
    EXPECT_NEAR(std::abs(pixel.x() - 319.5), 320.0, 1e-6);
    EXPECT_NEAR(std::abs(pixel.y() - 239.5), 240.0, 1e-6);
  }
  EXPECT_EQ(num_centers, 4U);
}

TEST(CameraMarkers, TheWayGrowsByWhatIsFarEnoughAndOnlyItsLastPartIsSent) {
  CameraMarkers markers("map");
  EXPECT_TRUE(find(markers.add(kCamera, poseAt(0, 0, 1)), "trajectory").empty());
  EXPECT_TRUE(find(markers.add(kCamera, poseAt(0.02, 0, 1)), "trajectory").empty());
  const std::size_t num_steps = 3 * CameraMarkers::kChunk;
  for (std::size_t i = 1; i <= num_steps; ++i) {
    const auto way =
        find(markers.add(kCamera, poseAt(0.1 * static_cast<double>(i), 0, 1)), "trajectory");
    ASSERT_EQ(way.size(), 1U);
    ASSERT_LE(way[0].points.size(), CameraMarkers::kChunk);
    EXPECT_DOUBLE_EQ(way[0].points.back().x, 0.1 * static_cast<double>(i));
  }
  double length_m = 0.0;
  for (const Marker& way : find(markers.all(), "trajectory")) {
    length_m += way.points.back().x - way.points.front().x;
  }
  EXPECT_NEAR(length_m, 0.1 * static_cast<double>(num_steps), 1e-9);
}

TEST(CameraMarkers, NoLineLeadsToWhereTheCameraWasPut) {
  CameraMarkers markers("map");
  for (const double x_m : {0.0, 1.0, 11.0, 12.0}) markers.add(kCamera, poseAt(x_m, 0, 1));
  const auto ways = find(markers.all(), "trajectory");
  ASSERT_EQ(ways.size(), 2U);
  EXPECT_EQ(ways[0].points.back().x, 1.0);
  EXPECT_EQ(ways[1].points.front().x, 11.0);
}

TEST(CameraMarkers, AWayOfBeforeTakesThePlaceOfAllAndEndsAtTheCamera) {
  CameraMarkers markers("map");
  for (const double x_m : {0.0, 1.0}) markers.add(kCamera, poseAt(x_m, 0, 1));
  Trajectory trajectory;
  for (int i = 0; i < 10; ++i) trajectory.add({i + 1}, poseAt(0, 0.5 * i, 1));
  const MarkerArray array = markers.restore(trajectory);
  EXPECT_EQ(array.markers.front().action, Marker::DELETEALL);
  const auto ways = find(array, "trajectory");
  ASSERT_EQ(ways.size(), 1U);
  EXPECT_EQ(ways[0].points.size(), 10U);
  EXPECT_EQ(find(array, "camera_axes").at(0).points.front().y, 4.5);
  EXPECT_TRUE(find(array, "camera_frustum").empty());
  EXPECT_EQ(markers.clear().markers.size(), 1U);
}

}  // namespace
}  // namespace tsg::ros_interface
