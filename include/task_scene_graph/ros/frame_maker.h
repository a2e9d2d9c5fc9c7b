// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/ros/camera_intrinsics.h"
#include "task_scene_graph/ros/input_config.h"
#include "task_scene_graph/ros/source_image.h"

namespace tsg::ros_interface {

/// Names of topics as they are told to the user.
struct InputTopics {
  std::string color;
  std::string depth;
  std::string camera_info;
};

/// A colour and a depth image -> a frame that lacks only its pose: decoding, intrinsics, depth
/// scale, sizes, rectification. Raw rgb8, bgr8 and depth images are borrowed, not copied, unless
/// they are to be resized or rectified. Not thread-safe.
class FrameMaker {
 public:
  /// @throws InputError if intrinsics are given that cannot be read.
  FrameMaker(const InputConfig& config, InputTopics topics);

  /// The last usable message holds until the next; ignored where the configuration has intrinsics.
  /// Returns a warning for the user, once for each kind, or nothing.
  /// @throws InputError for a message that cannot be used; the one before stays in force.
  std::optional<std::string> setCameraInfo(const sensor_msgs::CameraInfoConstPtr& info);
  bool hasCamera() const { return info_ != nullptr; }

  struct Result {
    std::shared_ptr<RgbdFrame> frame;
    bool is_color_shared = false;  ///< the frame reads the message's own bytes
    bool is_depth_shared = false;
  };
  /// @throws InputError naming what is wrong with the images or their intrinsics.
  Result make(const SourceImage& color, const SourceImage& depth);

  const InputTopics& topics() const { return topics_; }
  /// Null until there is one.
  const sensor_msgs::CameraInfo* cameraInfo() const { return info_.get(); }

 private:
  /// How images of two sizes become a frame.
  struct Plan {
    cv::Size color_size;
    cv::Size depth_size;
    CameraModel camera;          ///< of the frame
    ImageWarpPtr rectification;  ///< of colour, at its own size; null: none
    ImageWarpPtr color_warp;     ///< the whole way from the published image; null: none
    ImageWarpPtr depth_warp;     ///< null: none
  };

  /// @throws InputError if the sizes cannot be brought together, or fit no intrinsics.
  Plan makePlan(cv::Size color_size, cv::Size depth_size) const;
  void checkSizes(cv::Size color_size, cv::Size depth_size) const;
  const Plan& findPlan(cv::Size color_size, cv::Size depth_size);
  void warpColor(RgbdFrame& frame) const;
  Rectification chooseRectification() const;

  const InputConfig config_;
  const InputTopics topics_;
  const double metres_per_unit_;  ///< 0: by encoding
  sensor_msgs::CameraInfoConstPtr info_;
  bool is_warned_of_distortion_ = false;
  std::optional<Plan> plan_;  ///< of info_ and the newest images' sizes
};

}  // namespace tsg::ros_interface
