// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/pipeline/object_fusion.h"

#include <algorithm>
#include <utility>

#include "task_scene_graph/config/config.h"

namespace tsg::pipeline {
namespace {

const ObjectFusionConfig& requireValid(const ObjectFusionConfig& config) {
  config::validate(config, "object fusion");
  return config;
}

constexpr std::chrono::milliseconds kProgressPeriod{200};

/// Of events; what is held now is left out.
mapping::FrameBufferCounters sum(const mapping::FrameBufferCounters& a,
                                 const mapping::FrameBufferCounters& b) {
  mapping::FrameBufferCounters counters = a;
  counters.added += b.added;
  counters.evicted += b.evicted;
  counters.released += b.released;
  counters.unknown_segmentations += b.unknown_segmentations;
  return counters;
}

}  // namespace

ObjectFusion::ObjectFusion(const ObjectFusionConfig& config)
    : config_(requireValid(config)),
      alive_bytes_(std::make_shared<std::atomic<std::size_t>>(0)),
      reconstructor_(config.reconstruction),
      pool_(reconstructor_, config.object_threads,
            static_cast<std::size_t>(config.max_pending_tracks)) {
  framesOf(1);
}

mapping::FrameBuffer& ObjectFusion::framesOf(std::uint32_t epoch) {
  return frames_.try_emplace(epoch, config_.frame_buffer, alive_bytes_).first->second;
}

void ObjectFusion::addFrame(const RgbdFramePtr& frame, const SegmentationPtr& segmentation,
                            std::uint32_t epoch) {
  framesOf(epoch).add(frame, segmentation);
  makeRoom();
}

void ObjectFusion::makeRoom() {
  const std::size_t max_bytes =
      static_cast<std::size_t>(config_.frame_buffer.max_megabytes) * 1000000U;
  while (aliveBytes() > max_bytes && pool_.numPending() > 0) {
    pool_.waitForProgress(kProgressPeriod);
  }
  while (aliveBytes() > max_bytes) {
    mapping::FrameBuffer& oldest = frames_.begin()->second;
    if (oldest.counters().frames > 1) {
      oldest.evictOldest();
    } else if (frames_.size() > 1) {
      endEpoch(frames_.begin());
    } else {
      return;
    }
  }
}

void ObjectFusion::endEpoch(std::map<std::uint32_t, mapping::FrameBuffer>::iterator epoch) {
  former_frames_ = sum(former_frames_, epoch->second.counters());
  frames_.erase(epoch);
}

mapping::FrameBufferCounters ObjectFusion::frameCounters() const {
  mapping::FrameBufferCounters counters = former_frames_;
  for (const auto& [epoch, frames] : frames_) {
    counters = sum(counters, frames.counters());
    counters.frames += frames.counters().frames;
    counters.bytes += frames.counters().bytes;
  }
  return counters;
}

void ObjectFusion::submitTracks(const TrackedFrame& tracked, std::uint32_t epoch) {
  while (frames_.begin()->first < epoch && frames_.size() > 1) endEpoch(frames_.begin());
  mapping::FrameBuffer& frames = framesOf(epoch);
  for (const Track& track : tracked.finished) submit(track, frames, false);
  live_ = {tracked.live.begin(), tracked.live.end()};
  submitProvisional(tracked, frames);
  withdrawVanished(tracked);
  frames.update(tracked);
}

void ObjectFusion::submit(const Track& track, const mapping::FrameBuffer& frames,
                          bool is_provisional) {
  ++num_submitted_;
  pool_.submit(track, frames.collect(track), is_provisional);
}

void ObjectFusion::submitProvisional(const TrackedFrame& tracked,
                                     const mapping::FrameBuffer& frames) {
  const auto is_busy = [&] {
    return pool_.numPending() >= static_cast<std::size_t>(4 * config_.object_threads);
  };
  for (const Track& track : tracked.provisional) {
    if (!tracked.is_snapshot && is_busy()) continue;
    const auto known = provisional_.find(track.id);
    const std::size_t num_known = known == provisional_.end() ? 0 : known->second.num_observations;
    if (track.observations.size() <= num_known) continue;
    submit(track, frames, true);
  }
}

void ObjectFusion::withdrawVanished(const TrackedFrame& tracked) {
  std::set<TrackId> waiting;
  for (const Track& track : tracked.finished) waiting.insert(track.id);
  for (auto entry = provisional_.begin(); entry != provisional_.end();) {
    const bool is_known = entry->second.has_ended || live_.count(entry->first) > 0;
    if (waiting.count(entry->first) > 0) entry->second.has_ended = true;
    if (is_known || entry->second.has_ended) {
      ++entry;
    } else {
      withdrawn_.push_back(entry->second.id);
      entry = provisional_.erase(entry);
    }
  }
}

ObjectUpdate ObjectFusion::collect(bool wait) {
  ObjectUpdate update;
  for (auto& result : wait ? pool_.collectAll() : pool_.collectFinished()) {
    if (result.is_provisional) {
      addProvisional(std::move(result), update);
    } else {
      addFinal(std::move(result), update);
    }
    ++num_collected_;
  }
  update.withdrawn = std::move(withdrawn_);
  withdrawn_.clear();
  std::sort(update.withdrawn.begin(), update.withdrawn.end());
  return update;
}

void ObjectFusion::addFinal(mapping::PooledResult result, ObjectUpdate& update) {
  const auto known = provisional_.find(result.track);
  auto& primitive = result.result.primitive;
  if (primitive != nullptr) {
    primitive->id = known != provisional_.end() ? known->second.id : takeId();
    update.primitives.push_back(std::move(primitive));
  } else {
    ++rejections_[mapping::toString(result.result.status)];
    if (known != provisional_.end()) withdrawn_.push_back(known->second.id);
  }
  if (known != provisional_.end()) provisional_.erase(known);
}

void ObjectFusion::addProvisional(mapping::PooledResult result, ObjectUpdate& update) {
  auto& primitive = result.result.primitive;
  if (primitive == nullptr || live_.count(result.track) == 0) return;  // the final one follows
  const auto [entry, is_new] = provisional_.try_emplace(result.track);
  if (is_new) entry->second.id = takeId();
  entry->second.num_observations = result.num_observations;
  primitive->id = entry->second.id;
  primitive->is_provisional = true;
  update.primitives.push_back(std::move(primitive));
}

PrimitiveId ObjectFusion::takeId() { return {next_id_.value++}; }

ObjectUpdate ObjectFusion::addTracks(const TrackedFrame& tracked) {
  submitTracks(tracked);
  return collect(true);
}

void ObjectFusion::moveFrames(const std::function<Pose(Stamp)>& motion) {
  for (auto& [epoch, frames] : frames_) frames.moveFrames(motion);
}

void ObjectFusion::reset() {
  num_collected_ += pool_.collectAll().size();
  frames_.clear();
  framesOf(1);
  provisional_.clear();
  live_.clear();
  withdrawn_.clear();
}

}  // namespace tsg::pipeline
