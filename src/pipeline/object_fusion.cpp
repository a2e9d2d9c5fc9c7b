// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/pipeline/object_fusion.h"

namespace tsg::pipeline {

ObjectFusion::ObjectFusion(const ObjectFusionConfig& config)
    : frames_(config.frame_buffer), reconstructor_(config.reconstruction) {}

void ObjectFusion::addFrame(const RgbdFramePtr& frame, const SegmentationPtr& segmentation) {
  frames_.add(frame, segmentation);
}

std::vector<ObjectPrimitivePtr> ObjectFusion::addTracks(const TrackedFrame& tracked) {
  std::vector<ObjectPrimitivePtr> primitives;
  for (const Track& track : tracked.finished) {
    const auto result = reconstructor_.reconstruct(track, frames_, next_id_);
    if (result.primitive) {
      primitives.push_back(result.primitive);
      ++next_id_.value;
    } else {
      ++rejections_[mapping::toString(result.status)];
    }
  }
  frames_.update(tracked);
  return primitives;
}

}  // namespace tsg::pipeline
