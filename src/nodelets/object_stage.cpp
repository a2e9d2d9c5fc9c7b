// SPDX-License-Identifier: BSD-3-Clause
#include "object_stage.h"

#include <algorithm>
#include <utility>

#include "mesh_fusion_report.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/trajectory/correct_map.h"

namespace tsg::nodelets {
namespace {

std::size_t countBytes(const ObjectPrimitive& primitive) {
  const cv::Mat& thumbnail = primitive.thumbnail.image;
  return primitive.mesh.vertices.size() * 15U + primitive.mesh.triangles.size() * 12U +
         static_cast<std::size_t>(primitive.embedding.size()) * sizeof(float) +
         thumbnail.total() * thumbnail.elemSize();
}

}  // namespace

ObjectStage::ObjectStage(ros::NodeHandle& handle, const ObjectStageOptions& options,
                         ros_interface::StageReport& report)
    : options_(options),
      report_(report),
      fusion_(options.fusion),
      late_(report),
      publisher_(late_.advertise<msg::ObjectPrimitives>(
          handle, "object_primitives", 0,  // no bound: none may drop
          [this](ros_interface::PartSender& sender) { sendAll(sender); })),
      worker_(options.queue_size, [this](const Job& job) { process(job); }) {}

void ObjectStage::addFrame(const RgbdFramePtr& frame, const SegmentationPtr& segmentation) {
  const std::uint32_t epoch = epoch_.epoch();
  {
    const std::lock_guard<std::mutex> lock(tracks_mutex_);
    newest_frame_ = frame->stamp;
    report_.countDropped("object queue full", "", worker_.push([this, frame, segmentation, epoch] {
      fusion_.addFrame(frame, alignToFrame(*frame, segmentation), epoch);
    }));
  }
  releaseTracks(false);
}

void ObjectStage::addTracks(const msg::TracksConstPtr& message) {
  {
    const std::lock_guard<std::mutex> lock(tracks_mutex_);
    const std::uint32_t epoch =
        epoch_.follow(message->epoch, ros_interface::toStamp(message->header.stamp));
    held_tracks_.push_back({message, epoch, std::chrono::steady_clock::now()});
  }
  releaseTracks(false);
  arrivals_.note(message->sequence);
}

void ObjectStage::startEpoch() {
  const std::lock_guard<std::mutex> lock(tracks_mutex_);
  epoch_.startEpoch();
  newest_frame_ = {};
}

bool ObjectStage::isDue(const HeldTracks& held, std::chrono::steady_clock::time_point now) const {
  const std::chrono::duration<double> waited = now - held.arrival;
  if (waited.count() > options_.frame_patience_s) return true;  // the frame was dropped
  if (held.epoch != epoch_.epoch()) return held.epoch < epoch_.epoch();
  return ros_interface::toStamp(held.message->header.stamp) <= newest_frame_;
}

void ObjectStage::releaseTracks(bool all) {
  const std::lock_guard<std::mutex> lock(tracks_mutex_);
  const auto now = std::chrono::steady_clock::now();
  while (!held_tracks_.empty() && (all || isDue(held_tracks_.front(), now))) {
    const auto& held = held_tracks_.front();
    worker_.pushOrder([this, message = held.message, epoch = std::min(held.epoch, epoch_.epoch())] {
      const TrackedFrame tracked = ros_interface::fromMessage(*message);
      newest_tracks_ = tracked.stamp;
      fusion_.submitTracks(tracked, epoch);
    });
    held_tracks_.pop_front();
  }
}

void ObjectStage::process(const Job& job) {
  try {
    job();
    publish();
    reportObjects(fusion_, report_);
  } catch (const std::exception& e) {
    report_.countDropped("object error", std::string("dropped tracks: ") + e.what());
  }
}

void ObjectStage::publish(bool is_reset, bool wait) {
  const pipeline::ObjectUpdate update = fusion_.collect(wait);
  if (update.primitives.empty() && update.withdrawn.empty() && !is_reset) return;
  store(update);
  const msg::ObjectPrimitivesPtr message =
      ros_interface::toMessage(update.primitives, newest_tracks_, options_.world_frame);
  for (const PrimitiveId id : update.withdrawn) message->withdrawn.push_back(id.value);
  message->is_reset = is_reset ? 1 : 0;
  publishNext(message);
}

void ObjectStage::publishNext(const msg::ObjectPrimitivesPtr& message) {
  message->epoch = epoch_.epoch();
  const std::lock_guard<std::mutex> lock(sequence_mutex_);
  message->sequence = ++sequence_;
  publisher_.publish(message);
}

void ObjectStage::store(const pipeline::ObjectUpdate& update) {
  const std::lock_guard<std::mutex> lock(primitives_mutex_);
  for (const auto& primitive : update.primitives) primitives_[primitive->id] = primitive;
  for (const PrimitiveId id : update.withdrawn) primitives_.erase(id);
  report_.set("object primitives", std::to_string(primitives_.size()));
}

void ObjectStage::sendAll(ros_interface::PartSender& sender) const {
  PrimitiveId last;
  while (sender.waitForRoom()) {
    // Sent under the lock: whatever replaces or withdraws one of the part is published after it.
    const std::lock_guard<std::mutex> lock(primitives_mutex_);
    std::vector<ObjectPrimitivePtr> part;
    std::size_t bytes = 0;
    auto next = primitives_.upper_bound(last);
    for (; next != primitives_.end() && bytes < ros_interface::PartSender::kMaxPartBytes; ++next) {
      bytes += countBytes(*next->second);
      part.push_back(next->second);
    }
    if (!part.empty()) last = part.back()->id;
    const auto message = ros_interface::toMessage(
        part, part.empty() ? Stamp{} : part.back()->last_seen, options_.world_frame);
    message->epoch = epoch_.epoch();
    // What was published before this subscriber came is stored: with the last part it has it all.
    const std::lock_guard<std::mutex> sequence_lock(sequence_mutex_);
    const bool is_last = next == primitives_.end();
    message->sequence = is_last ? sequence_.load() : 0;
    if (!part.empty() || message->sequence > 0) sender.send(*message);
    if (is_last) return;
  }
}

void ObjectStage::check() {
  releaseTracks(false);
  report_.set("messages that wait for the object thread", std::to_string(worker_.size()));
  if (worker_.size() == 0) worker_.pushOrder([] {});  // publishes what was done meanwhile
}

void ObjectStage::flush(const msg::FlushRequest& request, const ros_interface::Patience& patience,
                        msg::FlushResponse& response) {
  waitForTracks(request.sequence, patience, response);
  waitForReconstruction(patience, response);
  response.sequence = sequence_;
  const auto all = primitives();
  const auto num_provisional =
      std::count_if(all.begin(), all.end(), [](const auto& p) { return p->is_provisional; });
  response.content = std::to_string(all.size()) + " object primitives, " +
                     std::to_string(num_provisional) + " of them provisional";
}

void ObjectStage::waitForTracks(std::uint64_t sequence, const ros_interface::Patience& patience,
                                msg::FlushResponse& response) {
  if (!arrivals_.wait(sequence, patience)) {
    response.missing.push_back("messages of the tracker have not arrived: it sent " +
                               std::to_string(sequence) + ", the newest here is " +
                               std::to_string(arrivals_.newest()));
  }
  releaseTracks(true);
  if (worker_.waitHandled(patience, [this] { return fusion_.numDone(); })) return;
  response.missing.push_back(std::to_string(worker_.size()) +
                             " frames and messages wait for the object thread");
}

void ObjectStage::waitForReconstruction(const ros_interface::Patience& patience,
                                        msg::FlushResponse& response) {
  const std::uint64_t all = fusion_.numSubmitted();
  const auto isDone = [&] {
    if (fusion_.numCollected() >= all) return true;
    if (worker_.size() == 0) worker_.pushOrder([] {});
    return false;
  };
  const bool is_done = waitPatiently(
      isDone, [this] { return fusion_.numDone() + worker_.numDone(); }, patience);
  worker_.waitHandled(patience);  // what was taken last is published
  if (is_done) return;
  response.missing.push_back(std::to_string(all - fusion_.numCollected()) +
                             " tracks are not yet reconstructed");
}

void ObjectStage::reset() {
  worker_.pushOrder([this] {
    fusion_.reset();
    {
      const std::lock_guard<std::mutex> lock(primitives_mutex_);
      primitives_.clear();
    }
    publish(true);
  });
}

void ObjectStage::begin(std::vector<ObjectPrimitivePtr> primitives) {
  worker_.pushOrder([this, primitives = std::move(primitives)] {
    if (!primitives.empty()) fusion_.continueIdsAfter(primitives.back()->id);
    store({primitives, {}});
  });
  worker_.waitHandled(ros_interface::Patience::from(60.0, 60.0));
}

void ObjectStage::restore(std::vector<ObjectPrimitivePtr> primitives) {
  worker_.pushOrder([this, primitives = std::move(primitives)] {
    fusion_.reset();
    if (!primitives.empty()) fusion_.continueIdsAfter(primitives.back()->id);
    {
      const std::lock_guard<std::mutex> lock(primitives_mutex_);
      primitives_.clear();
    }
    publish(true);
    std::vector<ObjectPrimitivePtr> part;
    std::size_t bytes = 0;
    for (const auto& primitive : primitives) {
      part.push_back(primitive);
      bytes += countBytes(*primitive);
      if (bytes < ros_interface::PartSender::kMaxPartBytes) continue;
      send(std::exchange(part, {}));
      bytes = 0;
    }
    if (!part.empty()) send(part);
  });
}

void ObjectStage::correct(const MapCorrectionPtr& correction) {
  worker_.pushOrder([this, correction] { follow(*correction); });
}

void ObjectStage::follow(const MapCorrection& correction) {
  const ros_interface::StageTimer timer;
  publish(false, true);
  fusion_.moveFrames([&](Stamp stamp) { return correction.motionAt(stamp); });
  std::vector<ObjectPrimitivePtr> moved;
  for (const ObjectPrimitivePtr& primitive : primitives()) {
    moved.push_back(
        trajectory::movePrimitive(primitive, correction.what.before, correction.what.correction));
    if (moved.back() == primitive) moved.pop_back();
  }
  if (!moved.empty()) send(moved, true);  // as one: half a correction would tear objects apart
  report_.set("corrections: duration of the last one of the objects [ms]",
              std::to_string(timer.elapsedMs()));
}

void ObjectStage::send(const std::vector<ObjectPrimitivePtr>& primitives, bool are_moved) {
  store({primitives, {}});
  const msg::ObjectPrimitivesPtr message =
      ros_interface::toMessage(primitives, primitives.back()->last_seen, options_.world_frame);
  for (std::size_t i = 0; are_moved && i < primitives.size(); ++i) {
    message->withdrawn.push_back(primitives[i]->id.value);  // what is there anew replaces it
  }
  publishNext(message);
}

void ObjectStage::stop() {
  worker_.stop();
  late_.stop();
}

std::vector<ObjectPrimitivePtr> ObjectStage::primitives() const {
  const std::lock_guard<std::mutex> lock(primitives_mutex_);
  std::vector<ObjectPrimitivePtr> all;
  all.reserve(primitives_.size());
  for (const auto& entry : primitives_) all.push_back(entry.second);
  return all;
}

}  // namespace tsg::nodelets
