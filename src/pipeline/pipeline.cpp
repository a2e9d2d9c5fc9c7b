// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/pipeline/pipeline.h"

#include <utility>

#include "task_scene_graph/core/period.h"

namespace tsg::pipeline {

Pipeline::Pipeline(const PipelineConfig& config, const scene_graph::TaskList& object_tasks,
                   const scene_graph::TaskList& place_tasks,
                   std::unique_ptr<segmentation::Segmenter> segmenter,
                   const std::string& world_frame)
    : segmenter_(std::move(segmenter)),
      tracker_(config.tracker),
      background_(config.mesh_fusion.background_fusion),
      places_(config.mesh_fusion.background_fusion.places),
      places_period_s_(config.mesh_fusion.background_fusion.places_period_s),
      objects_(config.mesh_fusion.object_fusion),
      scene_graph_(config.scene_graph, world_frame) {
  const auto& occupancy = config.mesh_fusion.background_fusion.occupancy;
  if (occupancy.enabled) occupancy_ = std::make_unique<mapping::OccupancyMap>(occupancy);
  scene_graph_.setObjectTasks(object_tasks);
  scene_graph_.setPlaceTasks(place_tasks);
}

void Pipeline::restore(const map::Map& map) {
  places_.restore(*map.placeMemory(), background_.free_space.config().tsdf.voxel_size_m);
  background_.surface.restore(map.meshBlocks());
  map::restoreBuilder(map, scene_graph_);
  if (!map.primitives().empty()) objects_.continueIdsAfter(map.primitives().back()->id);
  if (occupancy_ && map.occupancy()) *occupancy_ = mapping::OccupancyMap(*map.occupancy());
  trajectory_ = *map.trajectory();
  sources_ = map.sources();
  newest_ = map.stamp();
}

void Pipeline::process(const RgbdFramePtr& frame, const SegmentationPtr& recorded) {
  newest_ = frame->stamp;
  trajectory_.add(frame->stamp, frame->T_world_camera);
  times_.measure("background", [&] { integrate(*frame); });
  const SegmentationPtr segmentation = findSegmentation(*frame, recorded);
  if (segmentation) {
    objects_.addFrame(frame, segmentation);
    if (segmentation->image_embedding.size() > 0) {
      places_.addView(*frame, segmentation->image_embedding);
    }
    addTracks(times_.measure("tracking", [&] { return tracker_.update(*frame, *segmentation); }));
  }
  updatePlaces(false);
}

void Pipeline::integrate(const RgbdFrame& frame) {
  const RgbdFramePtr filtered = background_.filter(frame);
  const auto status = background_.free_space.integrate(*filtered).status;
  if (status == mapping::IntegrationStatus::kIntegrated) {
    places_.addPose({frame.stamp, frame.T_world_camera});
  }
  if (occupancy_) occupancy_->integrate(*filtered);
  background_.surface.integrate(*filtered);
}

map::MapPtr Pipeline::finish() {
  addTracks(tracker_.finish());
  updatePlaces(true);
  map::Map map = times_.measure("scene_graph", [&] { return map::makeMap(scene_graph_); });
  map.setTrajectory(std::make_shared<const Trajectory>(trajectory_));
  map.setMesh(background_.surface.config().tsdf.voxel_size_m, updateMesh());
  map.setPlaceMemory(std::make_shared<const places::PlaceMemory>(places_.memory()));
  if (occupancy_) map.setOccupancy(std::make_shared<const mapping::OccupancyMap>(*occupancy_));
  map.setSources(sources_);
  return map.snapshot();
}

std::vector<mapping::BlockMesh> Pipeline::updateMesh() {
  background_.surface.updateMesh();
  const mapping::MeshTable& meshes = background_.surface.meshes();
  std::vector<mapping::BlockMesh> blocks;
  for (const auto& block : meshes.blocks()) blocks.push_back({block, meshes.find(block).load()});
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
  const auto primitives =
      times_.measure("objects", [&] { return objects_.addTracks(tracked); }).primitives;
  if (primitives.empty()) return;
  times_.measure("scene_graph", [&] {
    scene_graph_.addPrimitives(primitives);
    return scene_graph_.snapshot();
  });
}

void Pipeline::updatePlaces(bool force) {
  if (!isDue(last_places_, newest_, places_period_s_) && !force) return;
  last_places_ = newest_;
  const PlaceGraphPtr places = times_.measure("places", [&] {
    const mapping::TsdfVolume changed = background_.free_space.takeChangedBlocks();
    places_.update(changed, changed.sortedBlockIndices(), newest_);
    return std::make_shared<const PlaceGraph>(places_.graph());
  });
  times_.measure("scene_graph", [&] {
    scene_graph_.setPlaces(places);
    return scene_graph_.snapshot();
  });
}

}  // namespace tsg::pipeline
