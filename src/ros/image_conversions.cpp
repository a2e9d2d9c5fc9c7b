// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/image_conversions.h"

#include <cv_bridge/cv_bridge.h>
#include <sensor_msgs/image_encodings.h>

#include <algorithm>
#include <cmath>

#include "task_scene_graph/ros/geometry_conversions.h"

namespace tsg::ros_interface {
namespace {

namespace encodings = sensor_msgs::image_encodings;

[[noreturn]] void failEncoding(const sensor_msgs::Image& message, const std::string& topic,
                               const std::string& expected) {
  throw InputError(
      "image on " + topic + " has encoding '" + message.encoding + "', expected " + expected,
      "wrong encoding");
}

/// An empty `encoding` shares the message's pixels.
cv_bridge::CvImageConstPtr share(const sensor_msgs::ImageConstPtr& message,
                                 const std::string& topic, const std::string& encoding) {
  if (message->width == 0 || message->height == 0) {
    throw InputError("image on " + topic + " is " + std::to_string(message->width) + "x" +
                     std::to_string(message->height) + ", expected at least one pixel");
  }
  try {
    return cv_bridge::toCvShare(message, encoding);
  } catch (const std::exception& e) {
    throw InputError("image on " + topic + " (" + std::to_string(message->width) + "x" +
                     std::to_string(message->height) + ", step " + std::to_string(message->step) +
                     ", " + std::to_string(message->data.size()) + " bytes, encoding '" +
                     message->encoding + "') cannot be read: " + e.what());
  }
}

/// cv_bridge turns the bytes of a big-endian image, but leaves it a matrix of bytes.
cv::Mat toType(const cv::Mat& image, int type) {
  if (image.type() == type || image.elemSize() != static_cast<std::size_t>(CV_ELEM_SIZE(type))) {
    return image;
  }
  return {image.rows, image.cols, type, image.data, image.step};
}

std::shared_ptr<const void> toOwner(const cv_bridge::CvImageConstPtr& image) {
  return {image.get(), [image](const void*) {}};
}

}  // namespace

ColorImage toColorImage(const sensor_msgs::ImageConstPtr& message, const std::string& topic) {
  const std::string& encoding = message->encoding;
  const bool is_rgb = encoding == encodings::RGB8;
  const bool is_bgr = encoding == encodings::BGR8;
  const bool is_convertible =
      encoding == encodings::MONO8 || encoding == encodings::RGBA8 || encoding == encodings::BGRA8;
  if (!is_rgb && !is_bgr && !is_convertible) {
    failEncoding(*message, topic, "rgb8 or bgr8 (or mono8, rgba8, bgra8, which cost a copy)");
  }
  const auto shared = share(message, topic, is_convertible ? encodings::RGB8 : std::string());
  ColorImage color;
  color.stamp = toStamp(message->header.stamp);
  color.image = shared->image;
  color.order = is_bgr ? ColorOrder::kBgr : ColorOrder::kRgb;
  color.owner = toOwner(shared);
  return color;
}

DepthImage toDepthImage(const sensor_msgs::ImageConstPtr& message, const std::string& topic) {
  const std::string& encoding = message->encoding;
  const bool is_millimetres = encoding == encodings::TYPE_16UC1 || encoding == encodings::MONO16;
  if (!is_millimetres && encoding != encodings::TYPE_32FC1) {
    failEncoding(*message, topic, "16UC1 (millimetres) or 32FC1 (metres)");
  }
  const auto shared = share(message, topic, "");
  DepthImage depth;
  depth.image = toType(shared->image, is_millimetres ? CV_16UC1 : CV_32FC1);
  depth.metres_per_unit = is_millimetres ? 0.001 : 1.0;
  depth.owner = toOwner(shared);
  return depth;
}

bool hasDistortion(const sensor_msgs::CameraInfo& info) {
  return std::any_of(info.D.begin(), info.D.end(), [](double d) { return std::abs(d) > 1e-9; });
}

bool isShared(const cv::Mat& image, const sensor_msgs::Image& message) {
  return !message.data.empty() && image.data >= message.data.data() &&
         image.data < message.data.data() + message.data.size();
}

sensor_msgs::ImagePtr toImageMessage(const cv::Mat& image, const std::string& encoding, Stamp stamp,
                                     const std::string& frame) {
  std_msgs::Header header;
  header.stamp = toRosTime(stamp);
  header.frame_id = frame;
  return cv_bridge::CvImage(header, encoding, image).toImageMsg();
}

}  // namespace tsg::ros_interface
