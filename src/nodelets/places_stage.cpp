// SPDX-License-Identifier: BSD-3-Clause
#include "places_stage.h"

#include <exception>
#include <utility>

#include "task_scene_graph/places/move_memory.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/ros/messages.h"

namespace tsg::nodelets {

PlacesStage::PlacesStage(ros::NodeHandle& handle, ros_interface::LateSubscribers& late,
                         const Options& options, ros_interface::StageReport& report)
    : options_(options),
      report_(report),
      publisher_(late.advertise<msg::PlaceGraph>(
          handle, "place_graph", 10,
          [this](ros_interface::PartSender& sender) { sendNewest(sender); })),
      view_budget_(options.max_view_bytes),
      extractor_(std::make_unique<places::PlaceExtractor>(options.places)),
      thread_([this] { run(); }) {}

void PlacesStage::update(mapping::TsdfVolume changed, const std::vector<places::CameraPose>& poses,
                         Stamp stamp) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (work_.request) {
      for (const auto& [index, block] : changed.blocks()) {
        work_.request->changed.allocateBlock(index) = *block;
      }
      work_.request->poses.insert(work_.request->poses.end(), poses.begin(), poses.end());
      work_.request->stamp = stamp;
    } else {
      work_.request = Request{std::move(changed), poses, stamp};
    }
  }
  changed_.notify_all();
}

void PlacesStage::addView(const RgbdFramePtr& frame, const SegmentationPtr& segmentation,
                          std::uint64_t num_corrections) {
  auto share = view_budget_.reserve(ros_interface::countBytes(*frame));
  if (share == nullptr) return report_.countDropped("view for places: queue full (bytes)");
  bool is_full = false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::deque<View>& views = num_corrections > num_corrections_ ? early_views_ : work_.views;
    is_full = views.size() >= options_.max_views;
    if (is_full) views.pop_front();
    views.push_back({frame, segmentation, std::move(share), num_corrections});
  }
  if (is_full) report_.countDropped("view for places: queue full");
  changed_.notify_all();
}

void PlacesStage::correct(const MapCorrectionPtr& correction) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++num_corrections_;
    if (correction != nullptr) {
      work_.correction = correction;
      corrected_.push_back(std::exchange(work_, {}));
    }
    while (!early_views_.empty() && early_views_.front().num_corrections <= num_corrections_) {
      work_.views.push_back(std::move(early_views_.front()));
      early_views_.pop_front();
    }
  }
  changed_.notify_all();
}

bool PlacesStage::waitIdle(std::chrono::steady_clock::time_point deadline) {
  std::unique_lock<std::mutex> lock(mutex_);
  return changed_.wait_until(lock, deadline, [this] { return isIdle(); });
}

std::shared_ptr<const places::PlaceMemory> PlacesStage::memory() const {
  const std::lock_guard<std::mutex> lock(extractor_mutex_);
  return std::make_shared<const places::PlaceMemory>(extractor_->memory());
}

void PlacesStage::restore(std::shared_ptr<const places::PlaceMemory> memory, double voxel_size_m) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    forgetWork();
    work_.memory = std::move(memory);
    work_.voxel_size_m = voxel_size_m;
  }
  changed_.notify_all();
}

void PlacesStage::clear(Stamp stamp) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    forgetWork();
    work_.is_cleared = true;
    work_.clear_stamp = stamp;
  }
  changed_.notify_all();
}

void PlacesStage::stop() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_stopped_ = true;
    forgetWork();
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

std::size_t PlacesStage::numWaitingViews() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return countViews();
}

std::size_t PlacesStage::countViews() const {
  std::size_t count = work_.views.size() + early_views_.size();
  for (const Work& work : corrected_) count += work.views.size();
  return count;
}

/// Precondition: mutex_ is held.
void PlacesStage::forgetWork() {
  ++num_clears_;
  corrected_.clear();
  work_ = {};
  early_views_.clear();
}

void PlacesStage::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return is_stopped_ || !corrected_.empty() || !work_.isEmpty(); });
    if (is_stopped_) return;
    Work work;
    if (corrected_.empty()) {
      work = std::exchange(work_, {});
    } else {
      work = std::move(corrected_.front());
      corrected_.pop_front();
    }
    const std::uint64_t num_clears = num_clears_;
    is_busy_ = true;
    lock.unlock();
    try {
      process(work, num_clears);
    } catch (const std::exception& e) {
      report_.countDropped("places error", std::string("no place graph: ") + e.what());
    }
    work = {};  // frees the images before anybody hears that nothing waits
    lock.lock();
    is_busy_ = false;
    changed_.notify_all();
  }
}

void PlacesStage::process(const Work& work, std::uint64_t num_clears) {
  const std::lock_guard<std::mutex> lock(extractor_mutex_);
  if (work.is_cleared) {
    extractor_ = std::make_unique<places::PlaceExtractor>(options_.places);
    PlaceGraph empty;
    empty.stamp = work.clear_stamp;
    publish(empty, num_clears);
  }
  if (work.memory != nullptr) {
    extractor_->restore(*work.memory, work.voxel_size_m);
    publish(extractor_->graph(), num_clears);
  }
  for (const auto& view : work.views) {
    extractor_->addView(*view.frame, view.segmentation->image_embedding);
  }
  if (work.request) update(*work.request);
  if (work.correction != nullptr) {
    follow(*work.correction);
  } else if (!work.request) {
    return;
  }
  publish(extractor_->graph(), num_clears);
}

void PlacesStage::update(const Request& request) {
  const ros_interface::StageTimer timer;
  const auto& changed = request.changed;
  for (const auto& pose : request.poses) extractor_->addPose(pose);
  extractor_->update(changed, changed.sortedBlockIndices(), request.stamp);
  report_.set("duration of the last place update [ms]", std::to_string(timer.elapsedMs()));
}

void PlacesStage::follow(const MapCorrection& correction) {
  const ros_interface::StageTimer timer;
  const trajectory::Deformation deformation = correction.makeDeformation();
  const places::PlaceMemory moved = places::moveMemory(
      extractor_->memory(), [&](const Eigen::Vector3d& p_m) { return deformation.motionAt(p_m); });
  extractor_->restore(moved, moved.voxel_size_m);
  report_.set("corrections: duration of the last one of the places [ms]",
              std::to_string(timer.elapsedMs()));
}

void PlacesStage::publish(const PlaceGraph& graph, std::uint64_t num_clears) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (num_clears != num_clears_) return;  // a graph of what is gone
  }
  const msg::PlaceGraphPtr message = ros_interface::toMessage(graph, options_.world_frame);
  message->sequence = sequence_ + 1;
  {
    const std::lock_guard<std::mutex> lock(publish_mutex_);
    newest_sent_ = message;
    publisher_.publish(message);
  }
  ++sequence_;
  if (options_.on_map) options_.on_map(graph, extractor_->plan());
  report_.set("places", std::to_string(graph.places.size()));
}

void PlacesStage::sendNewest(ros_interface::PartSender& sender) {
  const std::lock_guard<std::mutex> lock(publish_mutex_);
  if (newest_sent_ != nullptr) sender.send(*newest_sent_);
}

}  // namespace tsg::nodelets
