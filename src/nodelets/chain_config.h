// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mesh_fusion_config.h"
#include "scene_graph_config.h"
#include "segmenter_config.h"
#include "task_scene_graph/pipeline/pipeline.h"
#include "task_scene_graph/ros/input_config.h"
#include "tracker_config.h"

namespace tsg::nodelets {

/// A whole configuration file: section `input` and one for each stage. The same file serves the
/// nodelets and process_bag; what only one of them has a use for does not disturb the other.
struct ChainConfig {
  ros_interface::InputConfig input;
  SegmenterNodeletConfig segmenter;
  TrackerNodeletConfig tracker;
  MeshFusionNodeletConfig mesh_fusion;
  SceneGraphNodeletConfig scene_graph;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.group("input", self.input);
    v.group("segmenter", self.segmenter);
    v.group("tracker", self.tracker);
    v.group("mesh_fusion", self.mesh_fusion);
    v.group("scene_graph", self.scene_graph);
  }

  pipeline::PipelineConfig toPipeline() const {
    pipeline::PipelineConfig config;
    config.segmenter = segmenter.segmenter;
    config.tracker = tracker.tracker;
    config.mesh_fusion.background_fusion = mesh_fusion.background_fusion;
    config.mesh_fusion.object_fusion = mesh_fusion.object_fusion;
    config.scene_graph = scene_graph.scene_graph;
    return config;
  }
};

}  // namespace tsg::nodelets
