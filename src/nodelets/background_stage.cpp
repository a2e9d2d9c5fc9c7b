// SPDX-License-Identifier: BSD-3-Clause
#include "background_stage.h"

#include "mesh_fusion_report.h"
#include "task_scene_graph/pipeline/map_files.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/ros/messages.h"

namespace tsg::nodelets {

BackgroundStage::BackgroundStage(ros::NodeHandle& handle, const BackgroundStageOptions& options,
                                 ros_interface::StageReport& report)
    : options_(options),
      report_(report),
      fusion_(options.fusion),
      mesh_publisher_(handle, {options.world_frame, options.mesh_period_s}, fusion_, mutex_),
      places_publisher_(handle.advertise<msg::PlaceGraph>("place_graph", 10, true)),
      worker_(
          options.queue_size, [this](const Job& job) { process(job); },
          [this](const Job& job) {
            report_.countDropped(
                job.segmentation ? "view for places: queue full" : "integration queue full", "", 1);
          }) {
  if (fusion_.occupancy() == nullptr) return;
  occupancy_publisher_ = std::make_unique<ros_interface::OccupancyPublisher>(
      handle,
      ros_interface::OccupancyPublisher::Options{options.world_frame, options.octomap_period_s},
      *fusion_.occupancy(), mutex_);
}

void BackgroundStage::addFrame(const RgbdFramePtr& frame) { worker_.push({frame, nullptr}); }

void BackgroundStage::addView(const RgbdFramePtr& frame, const SegmentationPtr& segmentation) {
  if (segmentation->image_embedding.size() > 0) worker_.push({frame, segmentation});
}

void BackgroundStage::process(const Job& job) {
  try {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (job.segmentation != nullptr) {
      fusion_.addView(*job.frame, job.segmentation->image_embedding);
      return;
    }
    const ros_interface::StageTimer timer;
    fusion_.integrate(*job.frame);
    report_.countProcessed(timer.elapsedMs());
    newest_frame_ = job.frame->stamp;
    publish(false);
    reportBackground(fusion_, report_);
  } catch (const std::exception& e) {
    report_.countDropped("error", std::string("dropped a frame: ") + e.what());
  }
}

void BackgroundStage::publish(bool force) {
  mesh_publisher_.publish(newest_frame_, force);
  publishPlaces(force);
  if (occupancy_publisher_) occupancy_publisher_->publish(newest_frame_, force);
}

void BackgroundStage::publishPlaces(bool force) {
  const PlaceGraphPtr places = fusion_.updatePlaces(newest_frame_, force);
  if (places == nullptr) return;
  newest_places_ = newest_frame_;
  places_publisher_.publish(ros_interface::toMessage(*places, options_.world_frame));
  report_.set("places", std::to_string(places->places.size()));
}

void BackgroundStage::check() {
  report_.set("frames that wait for integration", std::to_string(worker_.size()));
}

bool BackgroundStage::flush(std::chrono::steady_clock::time_point deadline) {
  const bool is_done = worker_.waitIdle(deadline);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (newest_frame_ != Stamp{}) publish(true);
  return is_done;
}

Stamp BackgroundStage::newestFrame() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return newest_frame_;
}

Stamp BackgroundStage::newestPlaces() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return newest_places_;
}

std::vector<WrittenFile> BackgroundStage::writeFiles(
    const std::filesystem::path& folder, const std::vector<ObjectPrimitivePtr>& primitives,
    const std::map<PrimitiveId, std::int32_t>& object_of_primitive) {
  std::unique_lock<std::mutex> lock(mutex_);
  const Mesh mesh = fusion_.extractMesh();
  std::vector<WrittenFile> files = pipeline::writeOccupancyFiles(folder, fusion_.occupancy());
  lock.unlock();
  files.insert(files.begin(), pipeline::writeMeshFile(folder, mesh, primitives, object_of_primitive,
                                                      options_.fusion.background.tsdf.voxel_size_m,
                                                      options_.world_frame));
  return files;
}

}  // namespace tsg::nodelets
