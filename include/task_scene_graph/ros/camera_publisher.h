// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <chrono>
#include <mutex>
#include <string>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/ros/camera_markers.h"
#include "task_scene_graph/ros/late_subscribers.h"

namespace tsg::ros_interface {

/// CameraMarkers on the topic `camera_markers`, of which a late subscriber is first sent all.
/// Thread-safe.
class CameraPublisher {
 public:
  /// @param late  must be stopped before this object goes
  CameraPublisher(ros::NodeHandle& handle, LateSubscribers& late, const std::string& world_frame);

  /// The camera is there now; sent kPeriod after the one before at the earliest.
  void add(const CameraModel& camera, const Pose& T_world_camera);
  void restore(const Trajectory& trajectory);
  void clear();

 private:
  static constexpr std::chrono::milliseconds kPeriod{100};
  static constexpr std::uint32_t kQueueSize = 100;

  std::mutex mutex_;  ///< guards the two below, and the order of what is sent
  CameraMarkers markers_;
  std::chrono::steady_clock::time_point last_sent_;
  ros::Publisher publisher_;
};

}  // namespace tsg::ros_interface
