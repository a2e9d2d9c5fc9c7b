// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/source_image.h"

#include <cv_bridge/cv_bridge.h>
#include <sensor_msgs/image_encodings.h>

#include <cstring>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "rvl.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/image_conversions.h"

namespace tsg::ros_interface {
namespace {

namespace encodings = sensor_msgs::image_encodings;

// Leaves room for durations of years to be added within ROS's 32 bits.
constexpr std::uint32_t kLastSecond = 4000000000U;

/// Head of what compressed_depth_image_transport writes.
struct DepthHeader {
  std::int32_t format = 0;
  float quantisation_a = 0.0F;
  float quantisation_b = 0.0F;
};
static_assert(sizeof(DepthHeader) == 12, "laid out as in the message");

[[noreturn]] void fail(const sensor_msgs::CompressedImage& message, const std::string& topic,
                       const std::string& what) {
  throw InputError("compressed image on " + topic + " (format '" + message.format + "', " +
                       std::to_string(message.data.size()) + " bytes) " + what,
                   "unreadable compressed image");
}

bool endsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

cv::Mat decodeImage(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return {};
  const cv::Mat bytes(1, static_cast<int>(size), CV_8UC1, const_cast<std::uint8_t*>(data));
  try {
    return cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    return {};
  }
}

sensor_msgs::ImageConstPtr toMessage(const sensor_msgs::CompressedImage& message,
                                     const std::string& encoding, const cv::Mat& image) {
  return cv_bridge::CvImage(message.header, encoding, image).toImageMsg();
}

/// Quantised inverse depth: depth = a / (value - b), 0 where there was none.
cv::Mat toMetres(const cv::Mat& quantised, const DepthHeader& header) {
  cv::Mat depth(quantised.size(), CV_32FC1);
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const std::uint16_t value = quantised.at<std::uint16_t>(v, u);
      depth.at<float>(v, u) =
          value == 0 ? std::numeric_limits<float>::quiet_NaN()
                     : header.quantisation_a / (static_cast<float>(value) - header.quantisation_b);
    }
  }
  return depth;
}

cv::Mat decodeDepthPixels(const sensor_msgs::CompressedImage& message, const std::string& topic) {
  const std::uint8_t* data = message.data.data() + sizeof(DepthHeader);
  const std::size_t size = message.data.size() - sizeof(DepthHeader);
  const cv::Mat pixels =
      contains(message.format, "rvl") ? decodeRvl(data, size) : decodeImage(data, size);
  if (pixels.type() != CV_16UC1 || pixels.empty()) {
    fail(message, topic, "cannot be decoded; expected a PNG (or RVL) of 16 bits after 12 bytes");
  }
  return pixels;
}

sensor_msgs::ImageConstPtr decodeDepth(const sensor_msgs::CompressedImage& message,
                                       const std::string& topic) {
  if (message.data.size() <= sizeof(DepthHeader)) fail(message, topic, "is cut short");
  const cv::Mat pixels = decodeDepthPixels(message, topic);
  const std::string encoding = message.format.substr(0, message.format.find(';'));
  if (encoding != encodings::TYPE_32FC1) return toMessage(message, encodings::TYPE_16UC1, pixels);
  DepthHeader header;
  std::memcpy(&header, message.data.data(), sizeof(header));
  return toMessage(message, encodings::TYPE_32FC1, toMetres(pixels, header));
}

std::string findEncoding(const cv::Mat& image) {
  switch (image.type()) {
    case CV_8UC1:
      return encodings::MONO8;
    case CV_8UC3:
      return encodings::BGR8;
    case CV_8UC4:
      return encodings::BGRA8;
    case CV_16UC1:
      return encodings::TYPE_16UC1;
    case CV_32FC1:
      return encodings::TYPE_32FC1;
    default:
      return "";
  }
}

sensor_msgs::ImageConstPtr decodeColor(const sensor_msgs::CompressedImage& message,
                                       const std::string& topic) {
  const cv::Mat image = decodeImage(message.data.data(), message.data.size());
  if (image.empty()) fail(message, topic, "cannot be decoded; expected a whole JPEG or PNG");
  const std::string encoding = findEncoding(image);
  if (encoding.empty()) {
    fail(message, topic,
         "decodes to OpenCV type " + std::to_string(image.type()) +
             ", expected 8 bits or 16 bits of one channel");
  }
  return toMessage(message, encoding, image);
}

}  // namespace

Stamp SourceImage::stamp() const { return toStamp(header().stamp); }

sensor_msgs::ImageConstPtr SourceImage::decode(const std::string& topic) const {
  if (raw_) return raw_;
  const bool is_depth =
      contains(compressed_->format, "compressedDepth") || endsWith(topic, "/compressedDepth");
  return is_depth ? decodeDepth(*compressed_, topic) : decodeColor(*compressed_, topic);
}

bool isCompressedTopic(const std::string& topic) {
  return endsWith(topic, "/compressed") || endsWith(topic, "/compressedDepth");
}

void checkStamp(const ::ros::Time& stamp, const std::string& topic) {
  if (stamp.isZero()) {
    throw InputError("a message on " + topic +
                         " has stamp 0, expected the time at which its image was taken (the driver "
                         "leaves header.stamp empty)",
                     "stamp is 0");
  }
  if (stamp.sec > kLastSecond) {
    throw InputError("a message on " + topic + " has stamp " + std::to_string(stamp.sec) +
                         " s, expected seconds since 1970 (or since the start of a simulation)",
                     "stamp out of range");
  }
}

}  // namespace tsg::ros_interface
