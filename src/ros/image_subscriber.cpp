// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/image_subscriber.h"

#include <ros/master.h>

#include <algorithm>
#include <utility>

namespace tsg::ros_interface {

ImageSubscriber::ImageSubscriber(const ::ros::NodeHandle& handle, const std::string& topic,
                                 std::uint32_t queue_size, Callback callback)
    : handle_(handle), queue_size_(queue_size), callback_(std::move(callback)) {
  subscribe(topic);
}

void ImageSubscriber::subscribe(const std::string& topic) {
  // Remapping may add or take away the ending.
  if (isCompressedTopic(handle_.resolveName(topic))) {
    subscriber_ = handle_.subscribe<sensor_msgs::CompressedImage>(
        topic, queue_size_, [this](const sensor_msgs::CompressedImageConstPtr& message) {
          callback_(SourceImage(message));
        });
  } else {
    subscriber_ = handle_.subscribe<sensor_msgs::Image>(
        topic, queue_size_,
        [this](const sensor_msgs::ImageConstPtr& message) { callback_(SourceImage(message)); });
  }
}

std::string ImageSubscriber::switchToCompressed() {
  const std::string raw = topic();
  if (isCompressedTopic(raw) || subscriber_.getNumPublishers() > 0) return "";
  ::ros::master::V_TopicInfo published;
  if (!::ros::master::getTopics(published)) return "";
  for (const char* ending : {"/compressedDepth", "/compressed"}) {
    const std::string compressed = raw + ending;
    const bool is_there =
        std::any_of(published.begin(), published.end(), [&](const ::ros::master::TopicInfo& info) {
          return info.name == compressed && info.datatype == "sensor_msgs/CompressedImage";
        });
    if (!is_there) continue;
    subscribe(compressed);
    return "nobody publishes " + raw + ", but " + compressed + " is there: reading that";
  }
  return "";
}

}  // namespace tsg::ros_interface
