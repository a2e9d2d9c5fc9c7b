// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "task_scene_graph/core/camera.h"
#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/core/trajectory.h"

namespace tsg::ros_interface {

/// The robot in rviz: namespaces camera_axes (where the camera is: x red, y green, z blue, optical
/// axes), camera_frustum (what it sees, up to kFrustum_m) and trajectory (its way so far, in
/// markers of at most kChunk points). Not thread-safe.
class CameraMarkers {
 public:
  static constexpr std::size_t kChunk = 256;
  static constexpr double kFrustum_m = 0.8;
  static constexpr double kStep_m = 0.05;  ///< between two points of the trajectory
  static constexpr double kJump_m = 2.0;   ///< of the trajectory: no line is drawn from there on

  explicit CameraMarkers(std::string world_frame) : world_frame_(std::move(world_frame)) {}

  /// The camera is there now. @returns what has changed in the picture. O(kChunk).
  visualization_msgs::MarkerArray add(const CameraModel& camera, const Pose& T_world_camera);
  /// Another way instead; the camera is at its end, and what it sees is not known.
  /// @returns as all(). O(poses).
  visualization_msgs::MarkerArray restore(const Trajectory& trajectory);
  /// Forgets all. @returns what deletes it.
  visualization_msgs::MarkerArray clear();
  /// The whole picture, for somebody who may have an older one: first all is deleted. O(points).
  visualization_msgs::MarkerArray all() const;

 private:
  using Points = std::vector<Eigen::Vector3d>;

  /// False if the point is too near to the one before.
  bool addPoint(const Eigen::Vector3d& p_world);
  visualization_msgs::Marker makeMarker(const char* ns, int id, int type, double width_m) const;
  visualization_msgs::Marker drawAxes() const;
  visualization_msgs::Marker drawFrustum() const;
  visualization_msgs::Marker drawChunk(std::size_t chunk) const;
  void drawCamera(visualization_msgs::MarkerArray& array) const;

  std::string world_frame_;
  std::vector<Points> chunks_;  ///< of the trajectory; the first point may be the last one's last
  std::optional<CameraModel> camera_;
  std::optional<Pose> T_world_camera_;
};

}  // namespace tsg::ros_interface
