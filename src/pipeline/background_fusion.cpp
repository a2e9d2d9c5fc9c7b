// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/pipeline/background_fusion.h"

#include <memory>

namespace tsg::pipeline {

mapping::BackgroundConfig BackgroundFusionConfig::makeFreeSpaceDefaults() {
  mapping::BackgroundConfig config;
  config.tsdf.voxel_size_m = 0.1;
  config.tsdf.truncation_m = 0.3;
  config.tsdf.carve_free_space = true;
  config.tsdf.with_color = false;
  config.with_mesh = false;
  return config;
}

BackgroundFusion::BackgroundFusion(const BackgroundFusionConfig& config)
    : depth_filter(config.depth_filter),
      surface(config.background),
      free_space(config.free_space) {}

RgbdFramePtr BackgroundFusion::filter(const RgbdFrame& frame) {
  frame.validate();
  auto filtered = std::make_shared<RgbdFrame>(frame);
  filtered->depth = depth_filter.apply(frame.depth, frame.camera);
  return filtered;
}

}  // namespace tsg::pipeline
