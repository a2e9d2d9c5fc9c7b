// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/core/primitives.h"

namespace tsg::mapping {

struct FrameBufferConfig {
  int max_megabytes = 1024;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("max_megabytes", self.max_megabytes, {1, 1e6}, "MB",
            "images kept for objects still in view; beyond it the oldest frame goes");
  }
};

/// A frame and what the segmenter said of it. The segmentation is null until it is known.
struct SegmentedFrame {
  RgbdFramePtr frame;
  SegmentationPtr segmentation;
};

struct FrameBufferCounters {
  std::size_t frames = 0;    ///< held now
  std::size_t bytes = 0;     ///< held now: pixels, labels and embeddings
  std::size_t added = 0;     ///< ever
  std::size_t evicted = 0;   ///< went because the buffer was full, though perhaps still needed
  std::size_t released = 0;  ///< went because no live track needed them
  std::size_t unknown_segmentations = 0;  ///< came without their frame in the buffer; ignored
};

/// Keeps the frames in which live tracks were seen, so that an object can be reconstructed when its
/// track ends. Frames are shared, never copied; the memory they hold is bounded. What it hands out
/// stays alive beyond it: aliveBytes() counts that, too.
///
/// Order of calls per frame: addFrame(), addSegmentation() once there is one, update() with what
/// the tracker says of it, after the tracks that it names as finished were reconstructed or their
/// frames collected. Not thread-safe.
class FrameBuffer {
 public:
  /// @throws config::ConfigError if a value is out of range.
  explicit FrameBuffer(const FrameBufferConfig& config);
  /// @param alive  counter of the bytes alive, shared by several buffers
  FrameBuffer(const FrameBufferConfig& config, std::shared_ptr<std::atomic<std::size_t>> alive);

  /// Keeps a frame until it is known whether a track needs it. A frame with a stamp already there
  /// replaces that one. O(log frames).
  void addFrame(const RgbdFramePtr& frame);
  /// Attaches a segmentation to the frame with its stamp.
  void addSegmentation(const SegmentationPtr& segmentation);
  void add(const RgbdFramePtr& frame, const SegmentationPtr& segmentation);

  /// Notes which tracks see the frame `tracked.stamp`; then drops all frames up to that stamp that
  /// no live track needs, those that were never segmented among them. Later frames stay.
  void update(const TrackedFrame& tracked);

  /// Moves all frames: T_world_camera becomes motion(stamp) * T_world_camera. Whoever has one from
  /// before has it as it was. O(frames).
  void moveFrames(const std::function<Pose(Stamp)>& motion);

  /// The frame with this stamp, with null pointers if it is not (or no longer) here.
  SegmentedFrame find(Stamp stamp) const;

  /// The frames of a track's observations in their order; null pointers where one is gone. Keeps
  /// them alive independently of the buffer, for another thread.
  std::vector<SegmentedFrame> collect(const Track& track) const;

  const FrameBufferCounters& counters() const { return counters_; }
  /// Bytes of segmented frames that this buffer holds, or anybody to whom it gave them. From any
  /// thread.
  std::size_t aliveBytes() const { return *alive_; }
  /// Lets the oldest frame go. False if there is none.
  bool evictOldest();

 private:
  struct Entry {
    SegmentedFrame images;
    std::set<TrackId> tracks;  ///< live tracks seen in this frame
    std::size_t bytes = 0;
  };
  using Entries = std::map<Stamp, Entry>;

  Entries::iterator erase(Entries::iterator entry);
  void setBytes(Entry& entry);
  void evictWhileFull();

  std::size_t max_bytes_;
  std::shared_ptr<std::atomic<std::size_t>> alive_;
  Entries entries_;  ///< by time
  FrameBufferCounters counters_;
};

}  // namespace tsg::mapping
