// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <yaml-cpp/yaml.h>

#include <boost/program_options.hpp>
#include <map>
#include <string>

namespace tsg::tools {

/// Command line options that stand for fields of section `input`; what is given wins over every
/// file.
class InputOptions {
 public:
  void addTo(boost::program_options::options_description& description) {
    for (const auto& [option, field, help] : kOptions) {
      description.add_options()(option, boost::program_options::value(&values_[field]), help);
    }
    description.add_options()("rectify", boost::program_options::bool_switch(&rectify_),
                              "remove the lens distortion that camera_info reports");
  }

  /// What was given, laid out as section `input`.
  YAML::Node toYaml() const {
    YAML::Node given(YAML::NodeType::Map);
    for (const auto& [field, value] : values_) {
      if (!value.empty()) given[field] = value;
    }
    if (rectify_) given["rectify"] = "true";
    return given;
  }

 private:
  struct Option {
    const char* option;
    const char* field;
    const char* help;
  };
  static constexpr Option kOptions[] = {
      {"world-frame", "world_frame", "frame in which the map is built (world)"},
      {"camera-frame", "camera_frame", "frame of the camera (that of the images)"},
      {"color-topic", "color_topic", "colour images, raw or compressed"},
      {"depth-topic", "depth_topic", "depth registered to colour, raw or compressedDepth"},
      {"camera-info-topic", "camera_info_topic", "intrinsics"},
      {"segmentation-topic", "segmentation_topic", "recorded segmentations"},
      {"sync-tolerance", "sync_tolerance_s", "s, between colour and depth (0.02)"},
      {"depth-scale", "depth_scale",
       "metres for one unit of the depth images, or, above 1, units for one metre (0.001 for "
       "16UC1, "
       "1 for 32FC1)"},
      {"intrinsics", "intrinsics",
       "instead of camera_info: fx,fy,cx,cy[,width,height] or a file (YAML, matrix)"},
      {"match-size", "match_size", "color_to_depth or depth_to_color, where their sizes differ"},
      {"pose-topic", "pose_topic", "poses: Odometry, PoseStamped, ...; instead of tf"},
      {"trajectory", "trajectory", "poses: file in TUM's format; instead of tf"},
      {"pose-frame", "pose_frame", "frame that those poses are of (their own, else the camera's)"},
      {"poses", "pose_direction", "camera_to_world or world_to_camera"},
      {"camera-axes", "camera_axes",
       "axes of the camera's frame: optical (or opencv), opengl, body (or flu, ros)"},
      {"max-pose-gap", "max_pose_gap_s", "s, between poses that may be interpolated (0.5)"},
      {"max-tf-gap", "max_tf_gap_s", "s, the same for tf, where holes are rare (0.5)"}};

  std::map<std::string, std::string> values_;  ///< by field; empty = not given
  bool rectify_ = false;
};

}  // namespace tsg::tools
