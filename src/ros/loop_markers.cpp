// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/loop_markers.h"

#include <algorithm>

#include "task_scene_graph/ros/geometry_conversions.h"

namespace tsg::ros_interface {
namespace {

using visualization_msgs::Marker;

Marker makeMarker(const char* ns, double width_m, const std::string& world_frame) {
  Marker marker;
  marker.header.frame_id = world_frame;  // stamp 0: rviz takes the newest transform
  marker.ns = ns;
  marker.type = Marker::LINE_LIST;
  marker.pose.orientation.w = 1.0;
  marker.scale.x = width_m;
  return marker;
}

std_msgs::ColorRGBA computeColor(const LoopMarkerLine& line) {
  std_msgs::ColorRGBA color;
  color.a = 1.0F;
  color.r = 0.9F;
  color.g = 0.1F;
  color.b = 0.1F;
  if (!line.is_accepted) return color;
  const double share = std::clamp(line.residual_m / kLargeResidual_m, 0.0, 1.0);
  color.r = static_cast<float>(0.1 + 0.9 * share);
  color.g = 0.8F;
  return color;
}

}  // namespace

visualization_msgs::MarkerArray makeLoopMarkers(const std::vector<LoopMarkerLine>& lines,
                                                const std::string& world_frame) {
  visualization_msgs::MarkerArray array;
  array.markers = {makeMarker("accepted", 0.03, world_frame),
                   makeMarker("rejected", 0.015, world_frame)};
  for (const LoopMarkerLine& line : lines) {
    Marker& marker = array.markers[line.is_accepted ? 0 : 1];
    marker.points.push_back(toPoint(line.from_m));
    marker.points.push_back(toPoint(line.to_m));
    marker.colors.insert(marker.colors.end(), 2, computeColor(line));
  }
  for (Marker& marker : array.markers) {
    marker.action = marker.points.empty() ? Marker::DELETE : Marker::ADD;
  }
  return array;
}

}  // namespace tsg::ros_interface
