// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "common_config.h"
#include "correction_config.h"
#include "task_scene_graph/pipeline/background_fusion.h"
#include "task_scene_graph/pipeline/object_fusion.h"
#include "task_scene_graph/planning/planner_config.h"
#include "task_scene_graph/ros/input_config.h"

namespace tsg::nodelets {

/// Private parameters of the nodelet: those of its stages, and how they are fed.
struct MeshFusionNodeletConfig {
  static constexpr const char* kStage = "mesh_fusion";

  pipeline::BackgroundFusionConfig background_fusion;
  pipeline::ObjectFusionConfig object_fusion;
  planning::PlannerConfig planner;
  ros_interface::InputConfig input;
  CorrectionConfig corrections;
  std::filesystem::path output;
  std::filesystem::path map;
  double mesh_period_s = 1.0;
  double octomap_period_s = 1.0;
  int queue_size = 100;
  int queue_megabytes = 512;
  int object_queue_size = 1000;
  int frame_cache = 150;
  CommonConfig common;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    pipeline::BackgroundFusionConfig::visit(self.background_fusion, v);
    pipeline::ObjectFusionConfig::visit(self.object_fusion, v);
    v.group("planner", self.planner);
    v.group("input", self.input);
    v.group("corrections", self.corrections);
    v.field("output", self.output, {}, "",
            "folder for mesh.ply, floor_*.pgm, map.bt and map.ot; empty = none");
    v.field("map", self.map, {}, "", "folder of a saved map to go on from; empty = none");
    v.field("mesh_period_s", self.mesh_period_s, {0.0, 3600.0}, "s",
            "least time (of the frames' stamps) between two updates of `mesh` and `mesh_blocks`");
    v.field("octomap_period_s", self.octomap_period_s, {0.0, 3600.0}, "s",
            "least time (of the frames' stamps) between two updates of `octomap`, "
            "`octomap_changes`, `octomap_markers`");
    v.field("queue_size", self.queue_size, {1, 10000}, "frames",
            "frames that wait for depth integration; the oldest is dropped");
    v.field("queue_megabytes", self.queue_megabytes, {1, 100000}, "MB",
            "images of the frames that wait for depth integration, and as much again for places "
            "and for the occupancy map; a frame beyond it is dropped");
    v.field("object_queue_size", self.object_queue_size, {10, 100000}, "messages",
            "segmented frames and tracks that wait for object reconstruction");
    v.field("frame_cache", self.frame_cache, {1, 10000}, "frames",
            "images that wait for their segmentation");
    CommonConfig::visit(self.common, v);
  }
};

}  // namespace tsg::nodelets
