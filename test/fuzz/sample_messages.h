// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cv_bridge/cv_bridge.h>
#include <geometry_msgs/PoseStamped.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <tf2_msgs/TFMessage.h>

#include <cstdint>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

/// Small valid messages of a camera of 32 x 24 pixels, for fuzzing.
namespace tsg::fuzz {

constexpr int kWidth = 32;
constexpr int kHeight = 24;

inline std_msgs::Header makeHeader(const std::string& frame, double seconds = 10.0) {
  std_msgs::Header header;
  header.stamp.fromSec(seconds);
  header.frame_id = frame;
  return header;
}

inline cv::Mat makeDepth() {
  cv::Mat depth(kHeight, kWidth, CV_16UC1, cv::Scalar(2000));
  depth.colRange(5, 9).setTo(0);
  return depth;
}

inline cv::Mat makeColor() { return cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar(10, 20, 200)); }

inline sensor_msgs::Image makeImage(const std::string& encoding, const cv::Mat& image,
                                    double seconds = 10.0) {
  return *cv_bridge::CvImage(makeHeader("camera", seconds), encoding, image).toImageMsg();
}

inline std::vector<std::uint8_t> encodeImage(const std::string& ending, const cv::Mat& image) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(ending, image, bytes);
  return bytes;
}

/// @param num_head_bytes  zeros before the image's own bytes: compressedDepth has 12
inline sensor_msgs::CompressedImage makeCompressed(const std::string& format,
                                                   const std::vector<std::uint8_t>& bytes,
                                                   std::size_t num_head_bytes = 0) {
  sensor_msgs::CompressedImage message;
  message.header = makeHeader("camera");
  message.format = format;
  message.data.assign(num_head_bytes, 0);
  message.data.insert(message.data.end(), bytes.begin(), bytes.end());
  return message;
}

/// An RVL image of 8 x 2 pixels: five zeros, then the rest.
inline std::vector<std::uint8_t> makeRvl() {
  const std::uint32_t words[] = {8, 2, 0x5b122222U, 0x22222200U};
  std::vector<std::uint8_t> bytes(sizeof(words));
  std::memcpy(bytes.data(), words, sizeof(words));
  return bytes;
}

inline sensor_msgs::CameraInfo makeCameraInfo() {
  sensor_msgs::CameraInfo info;
  info.header = makeHeader("camera");
  info.width = kWidth;
  info.height = kHeight;
  info.distortion_model = "plumb_bob";
  info.D = {0.1, -0.2, 0.001, 0.002, 0.05};
  info.K = {30.0, 0.0, 15.5, 0.0, 30.0, 11.5, 0.0, 0.0, 1.0};
  info.R = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  info.P = {29.0, 0.0, 15.0, 0.0, 0.0, 29.0, 11.0, 0.0, 0.0, 0.0, 1.0, 0.0};
  return info;
}

inline geometry_msgs::TransformStamped makeTransform(const std::string& parent,
                                                     const std::string& child, double seconds) {
  geometry_msgs::TransformStamped transform;
  transform.header = makeHeader(parent, seconds);
  transform.child_frame_id = child;
  transform.transform.translation.x = seconds;
  transform.transform.rotation.w = 1.0;
  return transform;
}

inline nav_msgs::Odometry makeOdometry(double seconds = 10.0) {
  nav_msgs::Odometry odometry;
  odometry.header = makeHeader("odom", seconds);
  odometry.child_frame_id = "base";
  odometry.pose.pose.orientation.w = 1.0;
  odometry.pose.pose.position.x = 1.0;
  return odometry;
}

}  // namespace tsg::fuzz
