// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <string>

#include "task_scene_graph/core/stamp.h"

namespace tsg::ros_interface {

/// An image as it was published: raw, or compressed and not decoded yet.
class SourceImage {
 public:
  SourceImage() = default;
  explicit SourceImage(sensor_msgs::ImageConstPtr raw) : raw_(std::move(raw)) {}
  explicit SourceImage(sensor_msgs::CompressedImageConstPtr compressed)
      : compressed_(std::move(compressed)) {}

  const std_msgs::Header& header() const { return raw_ ? raw_->header : compressed_->header; }
  Stamp stamp() const;
  bool isCompressed() const { return compressed_ != nullptr; }

  /// The image's message: the raw one itself, else what the compressed one decodes to.
  /// Reads what image_transport's plugins `compressed` (JPEG, PNG, 8 or 16 bits) and
  /// `compressedDepth` (PNG and RVL; 16UC1, and 32FC1 as quantised inverse depth) write.
  /// deviation: own decoders, because Debian packages none of these plugins.
  /// @throws InputError naming `topic`, the format and what was expected.
  sensor_msgs::ImageConstPtr decode(const std::string& topic) const;

 private:
  sensor_msgs::ImageConstPtr raw_;
  sensor_msgs::CompressedImageConstPtr compressed_;
};

/// True for names of topics that carry sensor_msgs/CompressedImage: .../compressed and
/// .../compressedDepth.
bool isCompressedTopic(const std::string& topic);

/// Throws if ROS gives the stamp a meaning of its own (0) or cannot calculate with it (the last
/// centuries before 2106 that fit its 32 bits: drivers that fill the field with ones).
/// @throws InputError "stamp is 0" or "stamp out of range", naming `topic`.
void checkStamp(const ::ros::Time& stamp, const std::string& topic);

}  // namespace tsg::ros_interface
