// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/pipeline/pipeline.h"

#include <utility>

namespace tsg::pipeline {

Pipeline::Pipeline(const PipelineConfig& config, const scene_graph::TaskList& object_tasks,
                   const scene_graph::TaskList& place_tasks,
                   std::unique_ptr<segmentation::Segmenter> segmenter,
                   const std::string& world_frame)
    : segmenter_(std::move(segmenter)),
      tracker_(config.tracker),
      background_(config.mesh_fusion.background_fusion),
      objects_(config.mesh_fusion.object_fusion),
      scene_graph_(config.scene_graph, world_frame) {
  scene_graph_.setObjectTasks(object_tasks);
  scene_graph_.setPlaceTasks(place_tasks);
}

void Pipeline::process(const RgbdFramePtr& frame, const SegmentationPtr& recorded) {
  newest_ = frame->stamp;
  times_.measure("background", [&] { return background_.integrate(*frame); });
  const SegmentationPtr segmentation = findSegmentation(*frame, recorded);
  if (segmentation) {
    objects_.addFrame(frame, segmentation);
    background_.addView(*frame, segmentation->image_embedding);
    addTracks(times_.measure("tracking", [&] { return tracker_.update(*frame, *segmentation); }));
  }
  updatePlaces(false);
}

scene_graph::SceneGraphPtr Pipeline::finish() {
  addTracks(tracker_.finish());
  updatePlaces(true);
  return times_.measure("scene_graph", [&] { return scene_graph_.snapshot(); });
}

SegmentationPtr Pipeline::findSegmentation(const RgbdFrame& frame,
                                           const SegmentationPtr& recorded) {
  if (recorded || !segmenter_) return alignToFrame(frame, recorded);
  return times_.measure("segmentation", [&] {
    const ColorImage& color = frame.color_warp ? frame.published_color : frame.color;
    return alignToFrame(frame, std::make_shared<const Segmentation>(segmenter_->segment(color)));
  });
}

void Pipeline::addTracks(const TrackedFrame& tracked) {
  const auto primitives = times_.measure("objects", [&] { return objects_.addTracks(tracked); });
  if (primitives.empty()) return;
  times_.measure("scene_graph", [&] {
    scene_graph_.addPrimitives(primitives);
    return scene_graph_.snapshot();
  });
}

void Pipeline::updatePlaces(bool force) {
  const PlaceGraphPtr places =
      times_.measure("places", [&] { return background_.updatePlaces(newest_, force); });
  if (!places) return;
  times_.measure("scene_graph", [&] {
    scene_graph_.setPlaces(places);
    return scene_graph_.snapshot();
  });
}

}  // namespace tsg::pipeline
