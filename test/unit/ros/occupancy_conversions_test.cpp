// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/occupancy_conversions.h"

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <cmath>
#include <sstream>
#include <string>

#include "synthetic_scene.h"

namespace tsg::ros_interface {
namespace {

const Stamp kStamp{12345678901};

/// A wall 2 m ahead of a camera at the origin, seen so often that voxels are clamped and merge.
mapping::OccupancyMap makeMap() {
  mapping::OccupancyConfig config;
  config.pixel_stride = 1;
  mapping::OccupancyMap map(config);
  const auto rendering =
      test::render({test::makePlane({2.05, 0, 0}, {-1, 0, 0}, {1, 2, 3})},
                   {80, 60, 40.0, 40.0, 39.5, 29.5}, test::lookAt({0.02, 0.03, 0.04}, {2, 0, 0}));
  for (int i = 0; i < 12; ++i) map.integrate(rendering.frame);
  return map;
}

TEST(OccupancyConversions, TheOctreeOfTheMessageHasTheMapsVoxels) {
  const mapping::OccupancyMap map = makeMap();
  const OctomapMessage message = toMessage(map, kStamp, "world");
  EXPECT_EQ(message.header.frame_id, "world");
  EXPECT_EQ(message.header.stamp.toNSec(), 12345678901U);
  EXPECT_EQ(message.id, "OcTree");
  EXPECT_TRUE(message.binary);
  octomap::OcTree octree(message.resolution);
  std::istringstream stream(std::string(message.data.begin(), message.data.end()),
                            std::ios::binary);
  octree.readBinaryData(stream);
  const auto voxels = map.voxels();
  ASSERT_GT(voxels.size(), 1000U);
  for (const auto& voxel : voxels) {
    const Eigen::Vector3d center = (voxel.index.cast<double>().array() + 0.5) * 0.1;
    const auto* node = octree.search(center.x(), center.y(), center.z());
    ASSERT_NE(node, nullptr);
    EXPECT_EQ(octree.isNodeOccupied(node), voxel.is_occupied);
  }
}

TEST(OccupancyConversions, ChangesListVoxelsAndTheirState) {
  const msg::OctomapChanges message =
      toMessage({{{-1, 2, 3}, true}, {{4, -5, 6}, false}}, 0.25, true, kStamp, "map");
  EXPECT_EQ(message.header.frame_id, "map");
  EXPECT_EQ(message.resolution, 0.25);
  EXPECT_TRUE(message.is_complete);
  EXPECT_EQ(message.indices, (std::vector<int>{-1, 2, 3, 4, -5, 6}));
  EXPECT_EQ(message.occupied, (std::vector<std::uint8_t>{1, 0}));
}

TEST(OccupancyConversions, MarkersFillExactlyTheOccupiedSpace) {
  const mapping::OccupancyMap map = makeMap();
  const auto markers = toMarkers(map, "world").markers;
  double volume_m3 = 0.0;
  for (const auto& marker : markers) {
    EXPECT_EQ(marker.header.frame_id, "world");
    EXPECT_EQ(marker.points.size(), marker.colors.size());
    EXPECT_EQ(marker.action == visualization_msgs::Marker::DELETE, marker.points.empty());
    volume_m3 += std::pow(marker.scale.x, 3) * static_cast<double>(marker.points.size());
    for (const auto& point : marker.points) {
      EXPECT_EQ(map.at({point.x, point.y, point.z}), mapping::Occupancy::kOccupied);
    }
  }
  double expected_m3 = 0.0;
  for (const auto& leaf : map.leaves()) {
    expected_m3 += leaf.is_occupied ? std::pow(leaf.side_m, 3) : 0.0;
  }
  EXPECT_GT(expected_m3, 1.0);
  EXPECT_NEAR(volume_m3, expected_m3, 1e-9);
}

}  // namespace
}  // namespace tsg::ros_interface
