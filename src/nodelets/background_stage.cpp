// SPDX-License-Identifier: BSD-3-Clause
#include "background_stage.h"

#include <exception>
#include <utility>

#include "mesh_fusion_report.h"
#include "task_scene_graph/core/parallel.h"
#include "task_scene_graph/core/period.h"
#include "task_scene_graph/trajectory/correct_map.h"

namespace tsg::nodelets {
namespace {

std::unique_ptr<OccupancyStage> makeOccupancyStage(ros::NodeHandle& handle,
                                                   ros_interface::LateSubscribers& late,
                                                   const BackgroundStageOptions& options,
                                                   ros_interface::StageReport& report) {
  if (!options.fusion.occupancy.enabled) return nullptr;
  return std::make_unique<OccupancyStage>(
      handle, late,
      OccupancyStage::Options{options.fusion.occupancy, options.world_frame,
                              options.octomap_period_s, options.queue_size,
                              options.max_queue_bytes},
      report);
}

std::vector<mapping::BlockMesh> load(const mapping::MeshTable& meshes, int num_threads) {
  std::vector<mapping::BlockMesh> blocks;
  for (const auto& block : meshes.blocks()) blocks.push_back({block, nullptr});
  parallelFor(blocks.size(), num_threads,
              [&](std::size_t i) { blocks[i].mesh = meshes.find(blocks[i].block).load(); });
  return blocks;
}

/// Of lists that ascend, in which a mesh that is the same has the same pointer.
mapping::MeshUpdate findChanges(const std::vector<mapping::BlockMesh>& before,
                                const std::vector<mapping::BlockMesh>& after) {
  mapping::MeshUpdate update;
  auto old = before.begin();
  for (const mapping::BlockMesh& block : after) {
    for (; old != before.end() && mapping::isBefore(old->block, block.block); ++old) {
      update.removed.push_back(old->block);
    }
    const bool is_known = old != before.end() && old->block == block.block;
    if (!is_known || old->mesh != block.mesh) update.changed.push_back(block);
    if (is_known) ++old;
  }
  for (; old != before.end(); ++old) update.removed.push_back(old->block);
  return update;
}

const char* describe(mapping::IntegrationStatus status) {
  return status == mapping::IntegrationStatus::kPoseOutOfRange
             ? "pose farther than 1000 km from the origin"
             : "no depth in range";
}

}  // namespace

BackgroundStage::BackgroundStage(ros::NodeHandle& handle, const BackgroundStageOptions& options,
                                 ros_interface::StageReport& report)
    : options_(options),
      report_(report),
      late_(report),
      budget_(options.max_queue_bytes),
      fusion_(std::make_unique<pipeline::BackgroundFusion>(options.fusion)),
      mesh_publisher_(handle, late_, report, options.world_frame,
                      options.fusion.background.tsdf.voxel_size_m * mapping::kBlockSide),
      camera_publisher_(handle, late_, options.world_frame),
      places_(handle, late_,
              {options.fusion.places, options.world_frame, options.queue_size,
               options.max_queue_bytes, options.on_map},
              report),
      occupancy_(makeOccupancyStage(handle, late_, options, report)),
      worker_(
          options.queue_size, [this](const Job& job) { process(job); },
          [this](const Job&) { report_.countDropped("integration queue full"); }) {}

void BackgroundStage::addFrame(const RgbdFramePtr& frame) {
  camera_publisher_.add(frame->camera, frame->T_world_camera);
  auto share = budget_.reserve(ros_interface::countBytes(*frame));
  if (share == nullptr) return report_.countDropped("integration queue full (bytes)");
  worker_.push({frame, std::move(share), num_resets_, nullptr});
}

void BackgroundStage::addView(const RgbdFramePtr& frame, const SegmentationPtr& segmentation) {
  if (segmentation->image_embedding.size() == 0) return;
  places_.addView(frame, segmentation, num_corrections_);
}

void BackgroundStage::correct(const MapCorrectionPtr& correction) {
  ++num_corrections_;
  worker_.pushOrder({nullptr, nullptr, num_resets_, correction});
}

void BackgroundStage::process(const Job& job) {
  if (job.correction != nullptr) {
    follow(job);
  } else {
    integrate(job);
  }
}

void BackgroundStage::integrate(const Job& job) {
  try {
    const ros_interface::StageTimer timer;
    const std::lock_guard<std::mutex> lock(mutex_);
    if (job.num_resets != num_resets_) return;
    trajectory_.add(job.frame->stamp, job.frame->T_world_camera);
    const RgbdFramePtr filtered = fusion_->filter(*job.frame);
    fusion_->free_space.integrate(*filtered);
    const auto result = fusion_->surface.integrate(*filtered);
    if (occupancy_) occupancy_->add(filtered);
    reportBackground(*fusion_, report_);
    if (result.status != mapping::IntegrationStatus::kIntegrated) {
      return report_.countDropped(describe(result.status));
    }
    newest_frame_ = job.frame->stamp;
    new_poses_.push_back({job.frame->stamp, job.frame->T_world_camera});
    if (isDue(last_mesh_, newest_frame_, options_.mesh_period_s)) {
      publishMesh(fusion_->surface.updateMesh());
    }
    if (isDue(last_places_, newest_frame_, options_.fusion.places_period_s)) requestPlaces();
    report_.countProcessed(timer.elapsedMs());
  } catch (const std::exception& e) {
    report_.countDropped("error", std::string("dropped a frame: ") + e.what());
  }
}

/// All that frames of before have made is on its way to the places then.
mapping::MeshTable BackgroundStage::takeMeshes(const Job& job) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (job.num_resets != num_resets_) return {};
  if (newest_frame_ != Stamp{}) {
    publishMesh(fusion_->surface.updateMesh());
    requestPlaces();
  }
  return fusion_->surface.meshes();
}

/// Only this thread changes volumes, so nobody has to wait while the new ones are made.
void BackgroundStage::follow(const Job& job) {
  const ros_interface::StageTimer timer;
  bool is_done = false;
  try {
    const mapping::MeshTable before = takeMeshes(job);
    const auto old = load(before, job.correction->how.num_threads);
    const auto moved = moveMeshes(old, *job.correction);
    const mapping::MeshUpdate update = findChanges(old, moved);
    auto fusion = std::make_unique<pipeline::BackgroundFusion>(options_.fusion);
    fusion->surface.restore(moved);
    const std::lock_guard<std::mutex> lock(mutex_);
    if (job.num_resets == num_resets_) {
      exchange(std::move(fusion), update, *job.correction);
      is_done = true;
    }
  } catch (const std::exception& e) {
    report_.warn("correction", std::string("the mesh has not followed a correction: ") + e.what());
  }
  places_.correct(is_done ? job.correction : nullptr);
  if (occupancy_ && is_done) occupancy_->correct(job.correction);
  report_.set("corrections: frames waited for the last one [ms]",
              std::to_string(timer.elapsedMs()));
}

std::vector<mapping::BlockMesh> BackgroundStage::moveMeshes(
    const std::vector<mapping::BlockMesh>& blocks, const MapCorrection& correction) const {
  trajectory::Deformation deformation = correction.makeDeformation();
  return trajectory::moveMesh(blocks, options_.fusion.background.tsdf.voxel_size_m, deformation,
                              correction.how.num_threads);
}

/// Precondition: mutex_ is held.
void BackgroundStage::exchange(std::unique_ptr<pipeline::BackgroundFusion> fusion,
                               const mapping::MeshUpdate& update, const MapCorrection& correction) {
  fusion_ = std::move(fusion);
  publishMesh(update);
  trajectory_ =
      trajectory::applyCorrection(correction.what.correction, correction.what.before, trajectory_);
  camera_publisher_.restore(trajectory_);
  last_mesh_ = last_places_ = std::nullopt;
}

void BackgroundStage::publishMesh(const mapping::MeshUpdate& update) {
  last_mesh_ = newest_frame_;
  mesh_publisher_.add(update, fusion_->surface.meshes(), newest_frame_);
}

void BackgroundStage::requestPlaces() {
  last_places_ = newest_frame_;
  places_.update(fusion_->free_space.takeChangedBlocks(), new_poses_, newest_frame_);
  new_poses_.clear();
}

void BackgroundStage::check() {
  report_.set("frames that wait for integration", std::to_string(worker_.size()));
  report_.set("frames that wait for integration [MB]",
              std::to_string(budget_.usedBytes() / 1000000));
  report_.set("views that wait for the places", std::to_string(places_.numWaitingViews()));
}

std::vector<std::string> BackgroundStage::flush(const ros_interface::Patience& patience) {
  std::vector<std::string> missing;
  if (!worker_.waitHandled(patience)) {
    missing.push_back(std::to_string(worker_.size()) + " frames are not yet integrated");
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (newest_frame_ != Stamp{}) {
      publishMesh(fusion_->surface.updateMesh());
      requestPlaces();
    }
  }
  if (!places_.waitIdle(patience.deadline)) missing.push_back("the places are still at work");
  if (!mesh_publisher_.waitIdle(patience.deadline)) {
    missing.push_back("the mesh is still being published");
  }
  if (occupancy_ && !occupancy_->flush(patience.deadline)) {
    missing.push_back("frames are not yet in the occupancy map");
  }
  return missing;
}

void BackgroundStage::reset() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++num_resets_;
  fusion_ = std::make_unique<pipeline::BackgroundFusion>(options_.fusion);
  mesh_publisher_.clear(newest_frame_);
  camera_publisher_.clear();
  places_.clear(newest_frame_);
  if (occupancy_) occupancy_->clear(newest_frame_);
  newest_frame_ = {};
  trajectory_ = {};
  new_poses_.clear();
  last_mesh_ = last_places_ = std::nullopt;
}

void BackgroundStage::stop() {
  worker_.stop();
  if (occupancy_) occupancy_->stop();
  places_.stop();
  mesh_publisher_.stop();
  late_.stop();
}

Stamp BackgroundStage::firstFrame() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return trajectory_.isEmpty() ? Stamp{} : Stamp{trajectory_.poses().begin()->first};
}

Stamp BackgroundStage::newestFrame() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return newest_frame_;
}

void BackgroundStage::restore(const map::Map& map) {
  auto fusion = std::make_unique<pipeline::BackgroundFusion>(options_.fusion);
  fusion->surface.restore(map.meshBlocks());
  mapping::MeshUpdate all;
  all.changed = map.meshBlocks();
  const std::lock_guard<std::mutex> lock(mutex_);
  ++num_resets_;
  fusion_ = std::move(fusion);
  newest_frame_ = map.stamp();
  trajectory_ = *map.trajectory();
  new_poses_.clear();
  last_mesh_ = last_places_ = std::nullopt;
  mesh_publisher_.clear(newest_frame_);
  publishMesh(all);
  camera_publisher_.restore(trajectory_);
  places_.restore(map.placeMemory(), options_.fusion.free_space.tsdf.voxel_size_m);
  if (occupancy_ && map.occupancy() != nullptr)
    occupancy_->restore(*map.occupancy(), newest_frame_);
  if (occupancy_ && map.occupancy() == nullptr) occupancy_->clear(newest_frame_);
}

map::Map BackgroundStage::makeMap() {
  map::Map map(options_.world_frame);
  std::unique_lock<std::mutex> lock(mutex_);
  publishMesh(fusion_->surface.updateMesh());
  const mapping::MeshTable meshes = fusion_->surface.meshes();
  map.setTrajectory(std::make_shared<const Trajectory>(trajectory_));
  lock.unlock();
  map.setMesh(options_.fusion.background.tsdf.voxel_size_m, load(meshes, 1));
  map.setPlaceMemory(places_.memory());
  if (occupancy_) map.setOccupancy(occupancy_->snapshot());
  return map;
}

}  // namespace tsg::nodelets
