// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/occupancy_conversions.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "task_scene_graph/ros/geometry_conversions.h"

namespace tsg::ros_interface {
namespace {

constexpr int kTreeDepth = 16;

template <typename Message>
Message makeMessage(Stamp stamp, const std::string& world_frame) {
  Message message;
  message.header.stamp = toRosTime(stamp);
  message.header.frame_id = world_frame;
  return message;
}

visualization_msgs::Marker makeCubes(int level, double side_m, const std::string& world_frame) {
  visualization_msgs::Marker marker;
  marker.header.frame_id = world_frame;  // stamp 0: rviz takes the newest transform
  marker.ns = "octomap";
  marker.id = level;
  marker.type = visualization_msgs::Marker::CUBE_LIST;
  marker.action = visualization_msgs::Marker::DELETE;
  marker.pose.orientation.w = 1.0;
  marker.scale.x = marker.scale.y = marker.scale.z = side_m;
  marker.color.a = 1.0F;
  return marker;
}

}  // namespace

std_msgs::ColorRGBA computeHeightColor(double z_m) {
  const auto channel = [&](double peak_m) {
    const double distance = std::abs(std::remainder(z_m - peak_m, 4.0));
    return static_cast<float>(std::clamp(1.4 - distance, 0.1, 1.0));
  };
  std_msgs::ColorRGBA color;
  color.r = channel(8.0 / 3.0);
  color.g = channel(4.0 / 3.0);
  color.b = channel(0.0);
  color.a = 1.0F;
  return color;
}

OctomapMessage toMessage(const mapping::OccupancyMap& map, Stamp stamp,
                         const std::string& world_frame) {
  auto message = makeMessage<OctomapMessage>(stamp, world_frame);
  message.binary = 1;
  message.id = "OcTree";
  message.resolution = map.config().resolution_m;
  const std::string data = map.serialize(true);
  message.data.assign(data.begin(), data.end());
  return message;
}

msg::OctomapChanges toMessage(const std::vector<mapping::OccupancyVoxel>& voxels,
                              double resolution_m, bool is_complete, Stamp stamp,
                              const std::string& world_frame) {
  auto message = makeMessage<msg::OctomapChanges>(stamp, world_frame);
  message.resolution = resolution_m;
  message.is_complete = is_complete ? 1 : 0;
  message.indices.reserve(3 * voxels.size());
  message.occupied.reserve(voxels.size());
  for (const auto& voxel : voxels) {
    message.indices.insert(message.indices.end(), voxel.index.data(), voxel.index.data() + 3);
    message.occupied.push_back(voxel.is_occupied ? 1 : 0);
  }
  return message;
}

visualization_msgs::MarkerArray toMarkers(const mapping::OccupancyMap& map,
                                          const std::string& world_frame) {
  visualization_msgs::MarkerArray array;
  const double resolution_m = map.config().resolution_m;
  for (int level = 0; level <= kTreeDepth; ++level) {
    array.markers.push_back(makeCubes(level, std::ldexp(resolution_m, level), world_frame));
  }
  for (const auto& leaf : map.leaves()) {
    if (!leaf.is_occupied) continue;
    const auto level = static_cast<std::size_t>(std::ilogb(1.5 * leaf.side_m / resolution_m));
    visualization_msgs::Marker& marker = array.markers.at(level);
    marker.action = visualization_msgs::Marker::ADD;
    marker.points.push_back(toPoint(leaf.center_m));
    marker.colors.push_back(computeHeightColor(leaf.center_m.z()));
  }
  return array;
}

}  // namespace tsg::ros_interface
