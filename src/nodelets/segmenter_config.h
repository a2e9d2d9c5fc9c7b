// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "common_config.h"
#include "task_scene_graph/segmentation/segmenter.h"

namespace tsg::nodelets {

/// Private parameters of the nodelet: those of its stage, and how it is fed.
struct SegmenterNodeletConfig {
  static constexpr const char* kStage = "segmenter";

  segmentation::SegmenterConfig segmenter;
  std::filesystem::path models;
  double patience_s = 5.0;
  CommonConfig common;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    segmentation::SegmenterConfig::visit(self.segmenter, v);
    v.field("models", self.models, {}, "", "YAML file of the model set");
    v.field("patience_s", self.patience_s, {0.1, 3600.0}, "s",
            "a topic that is silent for so long (wall time) is named in a warning");
    CommonConfig::visit(self.common, v);
  }
};

}  // namespace tsg::nodelets
