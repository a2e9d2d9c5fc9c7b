// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/camera_markers.h"

#include <utility>

#include "task_scene_graph/ros/geometry_conversions.h"

namespace tsg::ros_interface {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

constexpr double kAxes_m = 0.3;

std_msgs::ColorRGBA makeColor(float r, float g, float b) {
  std_msgs::ColorRGBA color;
  color.r = r;
  color.g = g;
  color.b = b;
  color.a = 1.0F;
  return color;
}

void addLine(Marker& lines, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  lines.points.push_back(toPoint(a));
  lines.points.push_back(toPoint(b));
}

}  // namespace

Marker CameraMarkers::makeMarker(const char* ns, int id, int type, double width_m) const {
  Marker marker;
  marker.header.frame_id = world_frame_;  // stamp 0: rviz takes the newest transform
  marker.ns = ns;
  marker.id = id;
  marker.type = type;
  marker.pose.orientation.w = 1.0;
  marker.scale.x = width_m;
  return marker;
}

Marker CameraMarkers::drawAxes() const {
  Marker axes = makeMarker("camera_axes", 0, Marker::LINE_LIST, 0.04);
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d end = kAxes_m * Eigen::Vector3d::Unit(axis);
    addLine(axes, T_world_camera_->translation(), *T_world_camera_ * end);
    const auto color =
        makeColor(axis == 0 ? 0.9F : 0.1F, axis == 1 ? 0.7F : 0.1F, axis == 2 ? 0.9F : 0.1F);
    axes.colors.insert(axes.colors.end(), 2, color);
  }
  return axes;
}

Marker CameraMarkers::drawFrustum() const {
  Marker frustum = makeMarker("camera_frustum", 0, Marker::LINE_LIST, 0.025);
  frustum.color = makeColor(0.95F, 0.45F, 0.0F);
  const double right_px = camera_->width_px - 0.5;
  const double bottom_px = camera_->height_px - 0.5;
  const Eigen::Vector2d corners_px[] = {
      {-0.5, -0.5}, {right_px, -0.5}, {right_px, bottom_px}, {-0.5, bottom_px}};
  for (int i = 0; i < 4; ++i) {
    const auto cornerOf = [&](const Eigen::Vector2d& corner_px) -> Eigen::Vector3d {
      return *T_world_camera_ * camera_->unproject(corner_px.x(), corner_px.y(), kFrustum_m);
    };
    addLine(frustum, T_world_camera_->translation(), cornerOf(corners_px[i]));
    addLine(frustum, cornerOf(corners_px[i]), cornerOf(corners_px[(i + 1) % 4]));
  }
  return frustum;
}

Marker CameraMarkers::drawChunk(std::size_t chunk) const {
  Marker way = makeMarker("trajectory", static_cast<int>(chunk), Marker::LINE_STRIP, 0.03);
  way.color = makeColor(0.15F, 0.3F, 0.65F);
  for (const Eigen::Vector3d& p_world : chunks_[chunk]) way.points.push_back(toPoint(p_world));
  return way;
}

void CameraMarkers::drawCamera(MarkerArray& array) const {
  if (!T_world_camera_) return;
  array.markers.push_back(drawAxes());
  if (camera_) array.markers.push_back(drawFrustum());
}

bool CameraMarkers::addPoint(const Eigen::Vector3d& p_world) {
  if (chunks_.empty()) {
    chunks_.push_back({p_world});
    return true;
  }
  const Eigen::Vector3d last = chunks_.back().back();
  const double step_m = (p_world - last).norm();
  if (step_m < kStep_m) return false;
  if (step_m > kJump_m) {
    chunks_.push_back({p_world});
  } else if (chunks_.back().size() == kChunk) {
    chunks_.push_back({last, p_world});
  } else {
    chunks_.back().push_back(p_world);
  }
  return true;
}

MarkerArray CameraMarkers::add(const CameraModel& camera, const Pose& T_world_camera) {
  camera_ = camera;
  T_world_camera_ = T_world_camera;
  MarkerArray changes;
  drawCamera(changes);
  // rviz warns of a line of one point.
  if (addPoint(T_world_camera.translation()) && chunks_.back().size() > 1) {
    changes.markers.push_back(drawChunk(chunks_.size() - 1));
  }
  return changes;
}

MarkerArray CameraMarkers::restore(const Trajectory& trajectory) {
  clear();
  for (const auto& [ns, pose] : trajectory.poses()) addPoint(pose.translation());
  if (!trajectory.isEmpty()) T_world_camera_ = trajectory.poses().rbegin()->second;
  return all();
}

MarkerArray CameraMarkers::clear() {
  chunks_.clear();
  camera_.reset();
  T_world_camera_.reset();
  return all();
}

MarkerArray CameraMarkers::all() const {
  MarkerArray array;
  array.markers.push_back(makeMarker("", 0, Marker::ARROW, 1.0));
  array.markers.back().action = Marker::DELETEALL;
  for (std::size_t chunk = 0; chunk < chunks_.size(); ++chunk) {
    if (chunks_[chunk].size() > 1) array.markers.push_back(drawChunk(chunk));
  }
  drawCamera(array);
  return array;
}

}  // namespace tsg::ros_interface
