// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "common_config.h"
#include "task_scene_graph/ros/input_config.h"
#include "task_scene_graph/segmentation/segmenter.h"

namespace tsg::nodelets {

/// Private parameters of the nodelet: those of its stage, and how it is fed.
struct SegmenterNodeletConfig {
  static constexpr const char* kStage = "segmenter";

  segmentation::SegmenterConfig segmenter;
  ros_interface::InputConfig input;
  std::filesystem::path models;
  CommonConfig common;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    segmentation::SegmenterConfig::visit(self.segmenter, v);
    v.field("models", self.models, {}, "", "YAML file of the model set");
    v.group("input", self.input);
    CommonConfig::visit(self.common, v);
  }
};

}  // namespace tsg::nodelets
