// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/pipeline/object_fusion.h"

#include "task_scene_graph/config/config.h"

namespace tsg::pipeline {
namespace {

const ObjectFusionConfig& requireValid(const ObjectFusionConfig& config) {
  config::validate(config, "object fusion");
  return config;
}

}  // namespace

ObjectFusion::ObjectFusion(const ObjectFusionConfig& config)
    : frames_(requireValid(config).frame_buffer),
      reconstructor_(config.reconstruction),
      pool_(reconstructor_, config.object_threads,
            static_cast<std::size_t>(config.max_pending_tracks)) {}

void ObjectFusion::addFrame(const RgbdFramePtr& frame, const SegmentationPtr& segmentation) {
  frames_.add(frame, segmentation);
}

void ObjectFusion::submitTracks(const TrackedFrame& tracked) {
  for (const Track& track : tracked.finished) pool_.submit(track, frames_.collect(track));
  frames_.update(tracked);
}

std::vector<ObjectPrimitivePtr> ObjectFusion::takePrimitives(bool wait) {
  std::vector<ObjectPrimitivePtr> primitives;
  for (auto& result : wait ? pool_.takeAll() : pool_.take()) {
    if (result.primitive) {
      result.primitive->id = next_id_;
      ++next_id_.value;
      primitives.push_back(std::move(result.primitive));
    } else {
      ++rejections_[mapping::toString(result.status)];
    }
  }
  return primitives;
}

std::vector<ObjectPrimitivePtr> ObjectFusion::addTracks(const TrackedFrame& tracked) {
  submitTracks(tracked);
  return takePrimitives(true);
}

}  // namespace tsg::pipeline
