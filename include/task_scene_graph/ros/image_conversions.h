// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include <stdexcept>
#include <string>
#include <utility>

#include "task_scene_graph/core/frame.h"

namespace tsg::ros_interface {

/// A message that cannot be used; the text names the topic, the value and what was expected.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& text, std::string reason = "unusable message")
      : std::runtime_error(text), reason_(std::move(reason)) {}
  /// A few words for a counter: "wrong encoding".
  const std::string& reason() const { return reason_; }

 private:
  std::string reason_;
};

/// rgb8 and bgr8 borrow the message's pixels; mono8, rgba8 and bgra8 are converted with one copy.
/// `topic` is for error texts. @throws InputError for any other encoding or a broken layout.
ColorImage toColorImage(const sensor_msgs::ImageConstPtr& message, const std::string& topic);

/// 16UC1 and mono16 (millimetres) and 32FC1 (metres); always borrows the message's pixels.
/// @throws InputError for any other encoding or a broken layout.
DepthImage toDepthImage(const sensor_msgs::ImageConstPtr& message, const std::string& topic);

/// True if the camera reports a lens distortion, that is, expects its images to be rectified first.
bool hasDistortion(const sensor_msgs::CameraInfo& info);

/// True if the matrix reads the message's own bytes (nothing was copied).
bool isShared(const cv::Mat& image, const sensor_msgs::Image& message);

/// A message that holds a copy of the image's pixels; for tests and tools.
sensor_msgs::ImagePtr toImageMessage(const cv::Mat& image, const std::string& encoding, Stamp stamp,
                                     const std::string& frame);

}  // namespace tsg::ros_interface
