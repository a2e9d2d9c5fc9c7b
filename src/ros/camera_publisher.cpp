// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/camera_publisher.h"

namespace tsg::ros_interface {

CameraPublisher::CameraPublisher(ros::NodeHandle& handle, LateSubscribers& late,
                                 const std::string& world_frame)
    : markers_(world_frame),
      publisher_(late.advertise<visualization_msgs::MarkerArray>(
          handle, "camera_markers", kQueueSize, [this](PartSender& sender) {
            const std::lock_guard<std::mutex> lock(mutex_);
            sender.send(markers_.all());
          })) {}

void CameraPublisher::add(const CameraModel& camera, const Pose& T_world_camera) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  if (now - last_sent_ < kPeriod) return;
  last_sent_ = now;
  publisher_.publish(markers_.add(camera, T_world_camera));
}

void CameraPublisher::restore(const Trajectory& trajectory) {
  const std::lock_guard<std::mutex> lock(mutex_);
  publisher_.publish(markers_.restore(trajectory));
}

void CameraPublisher::clear() {
  const std::lock_guard<std::mutex> lock(mutex_);
  publisher_.publish(markers_.clear());
}

}  // namespace tsg::ros_interface
