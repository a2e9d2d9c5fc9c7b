// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/frame_buffer.h"

#include <algorithm>
#include <utility>

#include "task_scene_graph/config/config.h"

namespace tsg::mapping {
namespace {

std::size_t countBytes(const cv::Mat& image) { return image.total() * image.elemSize(); }

std::size_t countBytes(const SegmentedFrame& images) {
  std::size_t bytes = countBytes(images.frame->color.image) + countBytes(images.frame->depth.image);
  if (images.segmentation) {
    bytes += countBytes(images.segmentation->labels);
    bytes += static_cast<std::size_t>(images.segmentation->embeddings.size()) * sizeof(float);
  }
  return bytes;
}

/// Keeps a frame and its segmentation, and is counted as long as anybody has one of them.
struct CountedFrame {
  CountedFrame(SegmentedFrame the_images, std::shared_ptr<std::atomic<std::size_t>> the_alive)
      : images(std::move(the_images)), bytes(countBytes(images)), alive(std::move(the_alive)) {
    *alive += bytes;
  }
  ~CountedFrame() { *alive -= bytes; }
  CountedFrame(const CountedFrame&) = delete;
  CountedFrame& operator=(const CountedFrame&) = delete;

  const SegmentedFrame images;
  const std::size_t bytes;
  const std::shared_ptr<std::atomic<std::size_t>> alive;
};

/// The same images; each pointer keeps the count.
SegmentedFrame countAlive(SegmentedFrame images,
                          const std::shared_ptr<std::atomic<std::size_t>>& alive) {
  const auto counted = std::make_shared<const CountedFrame>(std::move(images), alive);
  return {RgbdFramePtr(counted, counted->images.frame.get()),
          SegmentationPtr(counted, counted->images.segmentation.get())};
}

}  // namespace

FrameBuffer::FrameBuffer(const FrameBufferConfig& config)
    : FrameBuffer(config, std::make_shared<std::atomic<std::size_t>>(0)) {}

FrameBuffer::FrameBuffer(const FrameBufferConfig& config,
                         std::shared_ptr<std::atomic<std::size_t>> alive)
    : max_bytes_(static_cast<std::size_t>(config.max_megabytes) * 1000000U),
      alive_(std::move(alive)) {
  config::validate(config, "frame buffer");
}

void FrameBuffer::addFrame(const RgbdFramePtr& frame) {
  Entry& entry = entries_[frame->stamp];
  entry.images = {frame, nullptr};
  setBytes(entry);
  ++counters_.added;
  evictWhileFull();
}

void FrameBuffer::addSegmentation(const SegmentationPtr& segmentation) {
  const auto entry = entries_.find(segmentation->stamp);
  if (entry == entries_.end()) {
    ++counters_.unknown_segmentations;
    return;
  }
  entry->second.images = countAlive({entry->second.images.frame, segmentation}, alive_);
  setBytes(entry->second);
  evictWhileFull();
}

void FrameBuffer::add(const RgbdFramePtr& frame, const SegmentationPtr& segmentation) {
  addFrame(frame);
  addSegmentation(segmentation);
}

void FrameBuffer::update(const TrackedFrame& tracked) {
  const auto seen = entries_.find(tracked.stamp);
  if (seen != entries_.end()) {
    for (const TrackId track : tracked.segment_tracks) {
      if (track.isValid()) seen->second.tracks.insert(track);
    }
  }
  const std::set<TrackId> live(tracked.live.begin(), tracked.live.end());
  for (auto entry = entries_.begin(); entry != entries_.end() && entry->first <= tracked.stamp;) {
    const auto& tracks = entry->second.tracks;
    const bool is_needed = std::any_of(tracks.begin(), tracks.end(),
                                       [&](TrackId track) { return live.count(track) != 0; });
    if (is_needed) {
      ++entry;
    } else {
      entry = erase(entry);
      ++counters_.released;
    }
  }
}

void FrameBuffer::moveFrames(const std::function<Pose(Stamp)>& motion) {
  for (auto& [stamp, entry] : entries_) {
    const auto moved = std::make_shared<RgbdFrame>(*entry.images.frame);  // shares its pixels
    moved->T_world_camera = motion(stamp) * moved->T_world_camera;
    if (entry.images.segmentation == nullptr) {
      entry.images.frame = moved;
      continue;
    }
    // A copy, for a pointer to the one of before would keep its frame counted.
    const auto same = std::make_shared<const Segmentation>(*entry.images.segmentation);
    entry.images = countAlive({moved, same}, alive_);
  }
}

SegmentedFrame FrameBuffer::find(Stamp stamp) const {
  const auto entry = entries_.find(stamp);
  return entry == entries_.end() ? SegmentedFrame{} : entry->second.images;
}

std::vector<SegmentedFrame> FrameBuffer::collect(const Track& track) const {
  std::vector<SegmentedFrame> frames;
  frames.reserve(track.observations.size());
  for (const auto& observation : track.observations) frames.push_back(find(observation.stamp));
  return frames;
}

FrameBuffer::Entries::iterator FrameBuffer::erase(Entries::iterator entry) {
  counters_.bytes -= entry->second.bytes;
  const auto next = entries_.erase(entry);
  counters_.frames = entries_.size();
  return next;
}

void FrameBuffer::setBytes(Entry& entry) {
  counters_.bytes -= entry.bytes;
  entry.bytes = countBytes(entry.images);
  counters_.bytes += entry.bytes;
  counters_.frames = entries_.size();
}

void FrameBuffer::evictWhileFull() {
  while (counters_.bytes > max_bytes_ && entries_.size() > 1) evictOldest();
}

bool FrameBuffer::evictOldest() {
  if (entries_.empty()) return false;
  erase(entries_.begin());
  ++counters_.evicted;
  return true;
}

}  // namespace tsg::mapping
