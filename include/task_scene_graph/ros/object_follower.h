// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <chrono>
#include <map>
#include <mutex>

#include "task_scene_graph/core/id.h"
#include "task_scene_graph/ros/arrivals.h"
#include "task_scene_graph/ros/messages.h"

namespace tsg::ros_interface {

/// Knows from the topic `scene_graph` which primitives make up which object.
class ObjectFollower {
 public:
  explicit ObjectFollower(ros::NodeHandle& handle);

  /// Object of each primitive that is in one, by the newest graph; empty if there is none. Where
  /// somebody publishes graphs, waits for one not older than `stamp`, until the deadline.
  std::map<PrimitiveId, std::int32_t> findObjects(Stamp stamp,
                                                  std::chrono::steady_clock::time_point deadline);

 private:
  void onGraph(const msg::SceneGraphConstPtr& message);

  std::mutex mutex_;
  msg::SceneGraphConstPtr graph_;
  Arrivals graphs_;
  ros::Subscriber subscriber_;
};

}  // namespace tsg::ros_interface
