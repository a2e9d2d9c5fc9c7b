// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy_stage.h"

#include <exception>
#include <utility>

namespace tsg::nodelets {

OccupancyStage::OccupancyStage(ros::NodeHandle& handle, ros_interface::LateSubscribers& late,
                               const Options& options, ros_interface::StageReport& report)
    : options_(options),
      report_(report),
      budget_(options.max_frame_bytes),
      map_(options.occupancy),
      publisher_(handle, late, {options.world_frame, options.period_s}, map_, mutex_),
      worker_(
          options.max_frames, [this](const Job& job) { process(job); },
          [this](const Job&) { report_.countDropped("occupancy: queue full"); }) {}

void OccupancyStage::add(const RgbdFramePtr& frame) {
  auto share = budget_.reserve(ros_interface::countBytes(*frame));
  if (share == nullptr) return report_.countDropped("occupancy: queue full (bytes)");
  worker_.push({frame, std::move(share), num_clears_, nullptr});
}

void OccupancyStage::correct(const MapCorrectionPtr& correction) {
  worker_.pushOrder({nullptr, nullptr, num_clears_, correction});
}

void OccupancyStage::follow(const Job& job) {
  const ros_interface::StageTimer timer;
  const auto before = snapshot();  // only this thread and clear() change it
  const trajectory::Deformation deformation = job.correction->makeDeformation();
  mapping::OccupancyMap moved =
      before->moved([&](const Eigen::Vector3d& p_m) { return deformation.motionAt(p_m); });
  const std::lock_guard<std::mutex> lock(mutex_);
  if (job.num_clears != num_clears_) return;
  map_ = std::move(moved);
  publisher_.replace(newest_);
  report_.set("corrections: duration of the last one of the occupancy map [ms]",
              std::to_string(timer.elapsedMs()));
}

void OccupancyStage::process(const Job& job) {
  try {
    if (job.correction != nullptr) return follow(job);
    const std::lock_guard<std::mutex> lock(mutex_);
    if (job.num_clears != num_clears_) return;
    map_.integrate(*job.frame);
    newest_ = job.frame->stamp;
    publisher_.publish(newest_, false);
    reportCounters();
  } catch (const std::exception& e) {
    report_.countDropped("occupancy error", std::string("dropped a frame: ") + e.what());
  }
}

void OccupancyStage::reportCounters() {
  report_.set("occupancy: frames without depth in range",
              std::to_string(map_.counters().frames_without_depth));
  report_.set("occupancy: readings out of the octree",
              std::to_string(map_.counters().readings_out_of_tree));
}

bool OccupancyStage::flush(std::chrono::steady_clock::time_point deadline) {
  const bool is_done = worker_.waitIdle(deadline);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (newest_ != Stamp{}) publisher_.publish(newest_, true);
  return is_done;
}

void OccupancyStage::clear(Stamp stamp) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++num_clears_;
  map_ = mapping::OccupancyMap(options_.occupancy);
  newest_ = {};
  publisher_.clear(stamp);
}

std::shared_ptr<const mapping::OccupancyMap> OccupancyStage::snapshot() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::make_shared<const mapping::OccupancyMap>(map_);
}

void OccupancyStage::restore(const mapping::OccupancyMap& map, Stamp stamp) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++num_clears_;
  map_ = mapping::OccupancyMap(map);
  newest_ = stamp;
  publisher_.replace(stamp);
}

}  // namespace tsg::nodelets
