// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common_config.h"
#include "task_scene_graph/ros/input_config.h"
#include "task_scene_graph/tracking/tracker.h"

namespace tsg::nodelets {

/// Private parameters of the nodelet: those of its stage, and how it is fed.
struct TrackerNodeletConfig {
  static constexpr const char* kStage = "tracker";

  tracking::TrackerConfig tracker;
  ros_interface::InputConfig input;
  int frame_cache = 150;
  int queue_size = 30;
  double idle_finish_s = 10.0;
  CommonConfig common;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    tracking::TrackerConfig::visit(self.tracker, v);
    v.group("input", self.input);
    v.field("frame_cache", self.frame_cache, {1, 10000}, "frames",
            "images that wait for their segmentation");
    v.field("queue_size", self.queue_size, {1, 10000}, "frames",
            "segmented frames that wait for the tracker; the oldest is dropped");
    v.field("idle_finish_s", self.idle_finish_s, {0.0, 3600.0}, "s",
            "live tracks end when nothing has been segmented for so long (wall time); 0 = never");
    CommonConfig::visit(self.common, v);
  }
};

}  // namespace tsg::nodelets
