// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sensor_msgs/CameraInfo.h>

#include <string>

#include "task_scene_graph/core/camera.h"
#include "task_scene_graph/core/image_warp.h"

namespace tsg::ros_interface {

/// Reads intrinsics: 'fx,fy,cx,cy' or 'fx,fy,cx,cy,width,height' (px), or the path of a file that
/// holds such numbers, a 3x3 or 4x4 matrix, or YAML as camera_calibration and camera_info_manager
/// write it (camera_matrix, distortion_coefficients, projection_matrix, ...), or flat YAML keys fx,
/// fy, cx, cy, width, height. A width of 0 fits images of any size.
/// @throws InputError naming the text or file and what was expected.
sensor_msgs::CameraInfo loadIntrinsics(const std::string& text_or_path);

/// True for topics of rectified images by ROS's naming: a part of the name's last component (not
/// counting a transport's) is `rect`.
bool isRectifiedTopic(const std::string& image_topic);

/// Checked intrinsics of images of one size, and the warp that rectifies them.
struct Intrinsics {
  CameraModel camera;          ///< of the images as they are used
  ImageWarpPtr rectification;  ///< null: none
};

/// How the images that `info` speaks of are used.
enum class Rectification {
  kIgnored,  ///< images as published, lens distortion and all: K
  kDone,     ///< images are rectified already: P
  kWanted    ///< to be rectified: P, or K where P is all zeros
};

/// Intrinsics for images of `size`: `info` must be of that size (0x0 fits any), or of a larger one
/// that its binning and region of interest explain.
/// @throws InputError naming the topic, the value and what was expected: sizes, numbers that are
/// not finite, an unknown distortion model.
Intrinsics toIntrinsics(const sensor_msgs::CameraInfo& info, cv::Size size,
                        Rectification rectification, const std::string& topic);

/// Throws what toIntrinsics would for any image size. @throws InputError
void checkCameraInfo(const sensor_msgs::CameraInfo& info, const std::string& topic);

/// Intrinsics of the same images in another size.
CameraModel resizeCamera(const CameraModel& camera, cv::Size size);

}  // namespace tsg::ros_interface
