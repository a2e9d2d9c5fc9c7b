// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/transform_feed.h"

#include <exception>
#include <utility>

#include "task_scene_graph/ros/source_image.h"

namespace tsg::ros_interface {
namespace {

constexpr std::uint32_t kQueueSize = 100;

}  // namespace

TransformFeed::TransformFeed(tf2::BufferCore& buffer, TransformHistory& history,
                             std::function<void(const std::string&)> on_problem)
    : buffer_(buffer), history_(history), on_problem_(std::move(on_problem)), spinner_(1, &queue_) {
  handle_.setCallbackQueue(&queue_);
  using Message = tf2_msgs::TFMessageConstPtr;
  moving_ = handle_.subscribe<tf2_msgs::TFMessage>(
      "/tf", kQueueSize, [this](const Message& message) { addTransforms(*message, false); });
  static_ = handle_.subscribe<tf2_msgs::TFMessage>(
      "/tf_static", kQueueSize, [this](const Message& message) { addTransforms(*message, true); });
  spinner_.start();
}

TransformFeed::~TransformFeed() {
  moving_.shutdown();
  static_.shutdown();
  spinner_.stop();
}

void TransformFeed::addTransforms(const tf2_msgs::TFMessage& message, bool is_static) {
  for (const auto& transform : message.transforms) {
    try {
      if (!is_static) {
        checkStamp(transform.header.stamp, "/tf");
        history_.add(transform);
      }
      buffer_.setTransform(transform, "tf", is_static);
    } catch (const std::exception& e) {
      on_problem_("ignored a transform from '" + transform.child_frame_id + "' to '" +
                  transform.header.frame_id + "': " + e.what());
    }
  }
}

}  // namespace tsg::ros_interface
