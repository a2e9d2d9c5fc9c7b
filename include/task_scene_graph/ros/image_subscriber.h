// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <cstdint>
#include <functional>
#include <string>

#include "task_scene_graph/ros/source_image.h"

namespace tsg::ros_interface {

/// Subscribes to images, raw or compressed. A topic whose name ends in /compressed or
/// /compressedDepth is taken as such; where a raw topic has no publisher but its compressed form
/// has, `switchToCompressed()` changes over to that. Raw images arrive by pointer, never copied.
class ImageSubscriber {
 public:
  using Callback = std::function<void(SourceImage)>;

  /// Subscribes at once, on the handle's queue.
  ImageSubscriber(const ::ros::NodeHandle& handle, const std::string& topic,
                  std::uint32_t queue_size, Callback callback);

  /// To be called now and then while nothing has come. Returns what it did, for the log, or "".
  std::string switchToCompressed();
  const ::ros::Subscriber& subscriber() const { return subscriber_; }
  /// Resolved name of the topic that is read.
  std::string topic() const { return subscriber_.getTopic(); }
  void shutdown() { subscriber_.shutdown(); }

 private:
  void subscribe(const std::string& topic);

  ::ros::NodeHandle handle_;
  std::uint32_t queue_size_;
  Callback callback_;
  ::ros::Subscriber subscriber_;
};

}  // namespace tsg::ros_interface
