// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/object_follower.h"

#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/scene_graph_conversions.h"

namespace tsg::ros_interface {

ObjectFollower::ObjectFollower(ros::NodeHandle& handle)
    : subscriber_(handle.subscribe("scene_graph", 10, &ObjectFollower::onGraph, this)) {}

void ObjectFollower::onGraph(const msg::SceneGraphConstPtr& message) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    graph_ = message;
  }
  graphs_.noteStamp(toStamp(message->header.stamp));
}

std::map<PrimitiveId, std::int32_t> ObjectFollower::findObjects(
    Stamp stamp, std::chrono::steady_clock::time_point deadline) {
  if (subscriber_.getNumPublishers() > 0) graphs_.wait(0, stamp, deadline);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (graph_ == nullptr) return {};
  return scene_graph::computeObjectOfPrimitives(fromMessage(*graph_));
}

}  // namespace tsg::ros_interface
