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
  trajectory_.add(frame->stamp, frame->T_world_camera);
  times_.measure("background", [&] { return background_.integrate(*frame); });
  const SegmentationPtr segmentation = findSegmentation(*frame, recorded);
  if (segmentation) {
    objects_.addFrame(frame, segmentation);
    background_.addView(*frame, segmentation->image_embedding);
    addTracks(times_.measure("tracking", [&] { return tracker_.update(*frame, *segmentation); }));
  }
  updatePlaces(false);
}

map::MapPtr Pipeline::finish() {
  addTracks(tracker_.finish());
  updatePlaces(true);
  map::Map map = times_.measure("scene_graph", [&] { return map::makeMap(scene_graph_); });
  map.setTrajectory(std::make_shared<const Trajectory>(trajectory_));
  map.setMesh(background_.background().config().tsdf.voxel_size_m, updateMesh());
  return map.snapshot();
}

std::vector<mapping::BlockMesh> Pipeline::updateMesh() {
  background_.updateMesh();
  std::vector<mapping::BlockMesh> blocks;
  for (const auto& block : background_.background().meshBlocks()) {
    blocks.push_back({block, background_.background().findMesh(block)});
  }
  return blocks;
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
