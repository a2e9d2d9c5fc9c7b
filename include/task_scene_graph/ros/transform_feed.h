// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <functional>
#include <string>

#include "task_scene_graph/ros/transform_history.h"

namespace tsg::ros_interface {

/// Fills a buffer with what comes on /tf and /tf_static, as tf2_ros::TransformListener does, in a
/// thread of its own; notes the moving links' stamps as well, before the buffer has the transform.
/// A transform that cannot be taken costs only itself.
class TransformFeed {
 public:
  /// `buffer` and `history` must live longer.
  /// @param on_problem  from this object's thread: which transform was not taken and why
  TransformFeed(tf2::BufferCore& buffer, TransformHistory& history,
                std::function<void(const std::string&)> on_problem);
  /// Joins the thread.
  ~TransformFeed();
  TransformFeed(const TransformFeed&) = delete;
  TransformFeed& operator=(const TransformFeed&) = delete;

 private:
  void addTransforms(const tf2_msgs::TFMessage& message, bool is_static);

  tf2::BufferCore& buffer_;
  TransformHistory& history_;
  const std::function<void(const std::string&)> on_problem_;
  ::ros::CallbackQueue queue_;
  ::ros::NodeHandle handle_;
  ::ros::Subscriber moving_;
  ::ros::Subscriber static_;
  ::ros::AsyncSpinner spinner_;
};

}  // namespace tsg::ros_interface
