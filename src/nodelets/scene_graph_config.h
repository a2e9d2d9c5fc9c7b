// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common_config.h"
#include "task_scene_graph/ros/scene_graph_markers.h"
#include "task_scene_graph/scene_graph/config.h"

namespace tsg::nodelets {

/// Private parameters of the nodelet: those of the stage, its files and its picture.
struct SceneGraphNodeletConfig {
  static constexpr const char* kStage = "scene_graph";

  scene_graph::SceneGraphConfig scene_graph;
  std::filesystem::path object_tasks;
  std::filesystem::path place_tasks;
  std::filesystem::path models;
  std::filesystem::path output;
  std::filesystem::path map;
  std::string world_frame = "world";
  bool with_embeddings = false;
  std::vector<std::string> object_frames;
  std::vector<std::string> upstream = {"segmenter", "tracker", "mesh_fusion"};
  double patience_s = 15.0;
  ros_interface::MarkerConfig markers;
  CommonConfig common;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    scene_graph::SceneGraphConfig::visit(self.scene_graph, v);
    v.field("object_tasks", self.object_tasks, {}, "", "YAML file of the tasks for objects");
    v.field("place_tasks", self.place_tasks, {}, "",
            "YAML file of the tasks for regions; empty = those for objects");
    v.field(
        "models", self.models, {}, "",
        "YAML file of the model set: its alpha, and its text encoder for tasks without embeddings");
    v.field("output", self.output, {}, "", "folder for the map files; empty = none");
    v.field("map", self.map, {}, "", "folder of a saved map to go on from; empty = none");
    v.field("world_frame", self.world_frame, {}, "", "tf frame of the map");
    v.field("with_embeddings", self.with_embeddings, {}, "",
            "put embeddings into the message scene_graph");
    v.field("object_frames", self.object_frames, {}, "",
            "tasks whose objects get a tf frame each, object_<id>; '*': all; empty: none");
    v.field("upstream", self.upstream, {}, "",
            "stages that save_map flushes first, in order (those that are not there are passed "
            "over)");
    v.field("patience_s", self.patience_s, {0.1, 3600.0}, "s",
            "a topic that is silent for so long (wall time) is named in a warning");
    v.group("markers", self.markers);
    CommonConfig::visit(self.common, v);
  }
};

}  // namespace tsg::nodelets
