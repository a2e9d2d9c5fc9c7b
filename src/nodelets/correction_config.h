// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/loops/loop_closer.h"
#include "task_scene_graph/trajectory/deformation.h"
#include "task_scene_graph/trajectory/outside_correction.h"

namespace tsg::nodelets {

/// How a map follows corrections of its trajectory (docs/corrections.md).
struct CorrectionConfig {
  std::string odometry_frame;
  std::string path_topic;
  std::string path_frame;
  bool close_loops = false;
  double loop_period_s = 5.0;
  double min_motion_m = 0.05;
  double min_turn_rad = 0.01;
  trajectory::OutsideCorrectionConfig outside;
  trajectory::DeformationConfig deformation;
  loops::LoopConfig loops;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("odometry_frame", self.odometry_frame, {}, "",
            "frame in which the camera's poses never jump; the map follows when world_frame moves "
            "against it, or by path_topic; empty = poses are taken in world_frame, and nothing "
            "follows");
    v.field(
        "path_topic", self.path_topic, {}, "",
        "nav_msgs/Path of a SLAM system in world_frame: its newest poses of the whole way, "
        "which the map follows; empty = it follows jumps of world_frame -> odometry_frame in tf");
    v.field(
        "path_frame", self.path_frame, {}, "",
        "frame, fixed to the camera, that the poses of path_topic are of; empty = the camera's");
    v.field("close_loops", self.close_loops, {}, "",
            "whether places that are seen again correct the map, for robots that have only "
            "odometry; instead of path_topic and of tf");
    v.field("loop_period_s", self.loop_period_s, {0.0, 3600.0}, "s",
            "least time (of the frames' stamps) between two corrections by loop closures");
    v.field("min_motion_m", self.min_motion_m, {0.0, 1000.0}, "m",
            "a correction that moves the camera less, everywhere, and ...");
    v.field("min_turn_rad", self.min_turn_rad, {0.0, 3.2}, "rad", "... turns it less, waits");
    trajectory::OutsideCorrectionConfig::visit(self.outside, v);
    v.group("deformation", self.deformation);
    v.group("loops", self.loops);
  }
};

/// @throws std::runtime_error for a path_topic or close_loops without an odometry_frame, or both.
inline void checkCorrections(const CorrectionConfig& config) {
  if (config.close_loops && !config.path_topic.empty()) {
    throw std::runtime_error(
        "parameter corrections/close_loops is true and corrections/path_topic "
        "is '" +
        config.path_topic + "', expected one of them: who corrects the map?");
  }
  if (!config.odometry_frame.empty()) return;
  if (config.close_loops) {
    throw std::runtime_error(
        "parameter corrections/close_loops is true, but corrections/odometry_frame is empty, "
        "expected the frame in which the camera's poses never jump");
  }
  if (config.path_topic.empty()) return;
  throw std::runtime_error(
      "parameter corrections/path_topic is '" + config.path_topic +
      "', but corrections/odometry_frame is empty, expected the frame in which the camera's poses "
      "never jump (world_frame itself where they come from odometry alone)");
}

}  // namespace tsg::nodelets
