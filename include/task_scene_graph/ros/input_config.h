// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "task_scene_graph/config/visitor.h"

namespace tsg::ros_interface {

/// Axes of the frame that the camera's pose is given in.
enum class CameraAxes {
  kOptical,  ///< x right, y down, z forward (REP 103's optical frames, OpenCV)
  kOpenGl,   ///< x right, y up, z backward
  kBody      ///< x forward, y left, z up (REP 103's bodies)
};

enum class PoseDirection { kCameraToWorld, kWorldToCamera };

/// What to do where depth and colour differ in size.
enum class MatchSize {
  kNone,          ///< such frames are dropped
  kColorToDepth,  ///< colour and labels are brought to depth's size
  kDepthToColor   ///< depth is brought to colour's size
};

/// What the robot's camera gives, live and in bags alike: section `input` of the configuration.
/// Topic names without a leading slash lie in the stage's namespace, in a bag at the root.
struct InputConfig {
  std::string world_frame = "world";
  std::string camera_frame;
  std::string color_topic = "camera/color/image_raw";
  std::string depth_topic = "camera/aligned_depth_to_color/image_raw";
  std::string camera_info_topic = "camera/color/camera_info";
  std::string segmentation_topic = "segmentation";
  double sync_tolerance_s = 0.02;
  double depth_scale = 0.0;
  config::NumbersOrPath intrinsics;
  bool rectify = false;
  MatchSize match_size = MatchSize::kNone;
  std::string pose_topic;
  std::filesystem::path trajectory;
  std::string pose_frame;
  PoseDirection pose_direction = PoseDirection::kCameraToWorld;
  CameraAxes camera_axes = CameraAxes::kOptical;
  double max_pose_gap_s = 0.5;
  double max_tf_gap_s = 0.5;
  int queue_size = 60;
  double tf_timeout_s = 1.0;
  double patience_s = 5.0;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("world_frame", self.world_frame, {}, "", "frame in which the map is built");
    v.field(
        "camera_frame", self.camera_frame, {}, "",
        "frame of the camera (optical: x right, y down, z forward); empty = that of the images");
    v.field("color_topic", self.color_topic, {}, "",
            "colour images; a name that ends in /compressed is read as compressed images");
    v.field("depth_topic", self.depth_topic, {}, "",
            "depth registered to colour; also .../compressedDepth (or PNGs on .../compressed)");
    v.field("camera_info_topic", self.camera_info_topic, {}, "",
            "intrinsics of the colour images; the newest message holds until the next");
    v.field("segmentation_topic", self.segmentation_topic, {}, "",
            "segments of the colour images, from the segmenter or recorded");
    v.field("sync_tolerance_s", self.sync_tolerance_s, {0.0, 10.0}, "s",
            "colour and depth belong together if their stamps differ by no more; 0 = equal stamps "
            "only");
    v.field("depth_scale", self.depth_scale, {0.0, 1e7}, "m",
            "metres for one unit of the depth images (or, above 1, units for one metre); 0 = by "
            "encoding: 0.001 for 16UC1, 1 for 32FC1");
    v.field("intrinsics", self.intrinsics, {}, "",
            "instead of camera_info: 'fx,fy,cx,cy' or 'fx,fy,cx,cy,width,height' (px), or a file: "
            "YAML as camera_calibration writes it, or a 3x3 or 4x4 matrix");
    v.field("rectify", self.rectify, {}, "",
            "remove the lens distortion that camera_info reports from colour, depth and labels");
    v.choice("match_size", self.match_size,
             {{"none", MatchSize::kNone},
              {"color_to_depth", MatchSize::kColorToDepth},
              {"depth_to_color", MatchSize::kDepthToColor}},
             "where registered depth has another size than colour: drop the frame, or bring one to "
             "the size of the other");
    v.field("pose_topic", self.pose_topic, {}, "",
            "poses from nav_msgs/Odometry, geometry_msgs/PoseStamped, PoseWithCovarianceStamped or "
            "TransformStamped instead of from tf; empty = tf");
    v.field("trajectory", self.trajectory, {}, "",
            "poses from a file in TUM's format (stamp tx ty tz qx qy qz qw) instead of from tf");
    v.field("pose_frame", self.pose_frame, {}, "",
            "frame that the poses of pose_topic or trajectory are of; empty = the messages' own "
            "child frame, else the camera's");
    v.choice("pose_direction", self.pose_direction,
             {{"camera_to_world", PoseDirection::kCameraToWorld},
              {"world_to_camera", PoseDirection::kWorldToCamera}},
             "what the poses of pose_topic or trajectory map: camera coordinates to world "
             "coordinates, or the reverse");
    v.choice(
        "camera_axes", self.camera_axes,
        {{"optical", CameraAxes::kOptical},
         {"opengl", CameraAxes::kOpenGl},
         {"body", CameraAxes::kBody},
         {"opencv", CameraAxes::kOptical},
         {"flu", CameraAxes::kBody},
         {"ros", CameraAxes::kBody}},
        "axes of the camera's frame: optical or opencv (x right, y down, z forward), opengl (x "
        "right, y up, z backward), body, flu or ros (x forward, y left, z up)");
    v.field(
        "max_pose_gap_s", self.max_pose_gap_s, {0.0, 3600.0}, "s",
        "poses of pose_topic or trajectory that are further apart are not interpolated between");
    v.field(
        "max_tf_gap_s", self.max_tf_gap_s, {0.01, 3600.0}, "s",
        "frames in a longer hole of tf are dropped where the camera moved meanwhile, unless the "
        "link that has the hole is always published so seldom");
    v.field("queue_size", self.queue_size, {1, 10000}, "messages",
            "images that wait for their partner, frames that wait for a pose");
    v.field("tf_timeout_s", self.tf_timeout_s, {0.0, 60.0}, "s",
            "how long an image waits for the camera's pose before it is dropped");
    v.field("patience_s", self.patience_s, {0.1, 3600.0}, "s",
            "a topic that is silent for so long (wall time) is named in a warning");
  }
};

/// @throws config::ConfigError naming what cannot hold together (pose_topic and trajectory, a depth
/// scale that no camera has, an empty topic).
void checkInput(const InputConfig& config);

/// Metres for one unit; nothing where the encoding decides.
double toMetresPerUnit(double depth_scale);

}  // namespace tsg::ros_interface
