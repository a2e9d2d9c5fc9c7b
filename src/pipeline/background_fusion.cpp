// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/pipeline/background_fusion.h"

#include <algorithm>
#include <memory>

#include "task_scene_graph/core/period.h"

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
    : config_(config),
      depth_filter_(config.depth_filter),
      background_(config.background),
      free_space_(config.free_space),
      occupancy_(config.occupancy.enabled
                     ? std::make_unique<mapping::OccupancyMap>(config.occupancy)
                     : nullptr),
      places_(config.places) {}

mapping::IntegrationResult BackgroundFusion::integrate(const RgbdFrame& frame) {
  frame.validate();
  RgbdFrame filtered = frame;
  filtered.depth = depth_filter_.apply(frame.depth, frame.camera);
  const mapping::IntegrationResult carved = free_space_.integrate(filtered);
  changed_blocks_.insert(changed_blocks_.end(), carved.changed_blocks.begin(),
                         carved.changed_blocks.end());
  if (occupancy_) occupancy_->integrate(filtered);
  return background_.integrate(filtered);
}

void BackgroundFusion::addView(const RgbdFrame& frame, const Embedding& image_embedding) {
  if (image_embedding.size() > 0) places_.addView(frame, image_embedding);
}

PlaceGraphPtr BackgroundFusion::updatePlaces(Stamp now, bool force) {
  if (!isDue(last_places_, now, config_.places_period_s) && !force) return nullptr;
  last_places_ = now;
  std::sort(changed_blocks_.begin(), changed_blocks_.end(), mapping::isBefore);
  changed_blocks_.erase(std::unique(changed_blocks_.begin(), changed_blocks_.end()),
                        changed_blocks_.end());
  places_.update(free_space_.volume(), changed_blocks_, now);
  changed_blocks_.clear();
  return std::make_shared<const PlaceGraph>(places_.graph());
}

}  // namespace tsg::pipeline
