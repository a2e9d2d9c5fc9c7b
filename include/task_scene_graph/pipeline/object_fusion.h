// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/mapping/frame_buffer.h"
#include "task_scene_graph/mapping/object_reconstructor.h"
#include "task_scene_graph/mapping/reconstruction_pool.h"

namespace tsg::pipeline {

struct ObjectFusionConfig {
  mapping::FrameBufferConfig frame_buffer;
  mapping::ObjectConfig reconstruction;
  int object_threads = 2;
  int max_pending_tracks = 256;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.group("frame_buffer", self.frame_buffer);
    v.group("reconstruction", self.reconstruction);
    v.field("object_threads", self.object_threads, {1, 64}, "",
            "threads that reconstruct objects, besides those of depth integration");
    v.field("max_pending_tracks", self.max_pending_tracks, {1, 100000}, "tracks",
            "ended tracks that wait for reconstruction; beyond it, segmented frames wait");
  }
};

/// What has come out of reconstruction.
struct ObjectUpdate {
  std::vector<ObjectPrimitivePtr> primitives;  ///< new, or in place of a provisional one
  std::vector<PrimitiveId> withdrawn;          ///< provisional ones that are no more, ascending
};

/// From tracks to object primitives: keeps the segmented frames that live tracks need and
/// reconstructs each track from them once it has ended [Clio24, Sec. IV-A], and before that, where
/// the tracker describes a live one, a provisional primitive. Frames are shared, never copied.
///
/// Stamps may start anew (a bag in a loop): frames and tracks say in which epoch of the clock they
/// are, and each epoch's tracks are reconstructed from its own frames.
/// Not thread-safe: one worker owns it.
class ObjectFusion {
 public:
  explicit ObjectFusion(const ObjectFusionConfig& config);

  /// Keeps a segmented frame; must be given before the tracker's answer to it.
  /// Waits for reconstruction while the frames alive, those of tracks that wait included, take
  /// more than frame_buffer/max_megabytes; where nothing waits, the oldest frames go.
  /// @param epoch  counts from 1, never lower than before
  void addFrame(const RgbdFramePtr& frame, const SegmentationPtr& segmentation,
                std::uint32_t epoch = 1);

  /// Begins to reconstruct the tracks that have ended, on threads of its own, and lets go of the
  /// frames that no live track needs. Returns at once unless `max_pending_tracks` wait. Provisional
  /// tracks are passed over while many wait, unless it is a snapshot. Frames of epochs before are
  /// let go of.
  void submitTracks(const TrackedFrame& tracked, std::uint32_t epoch = 1);

  /// The primitives that are done since the last call; ids ascend in the order of submission, those
  /// of one frame in the order of their tracks' ids, whatever the number of threads. Tracks of
  /// which nothing can be reconstructed are counted by reason.
  /// @param wait  until all that was submitted is done.
  ObjectUpdate collect(bool wait);
  /// Waits until another track is reconstructed, none waits, or the time is over.
  void waitForProgress(std::chrono::milliseconds timeout) { pool_.waitForProgress(timeout); }

  /// submitTracks(), then collect(true).
  ObjectUpdate addTracks(const TrackedFrame& tracked);

  /// Moves the frames that live tracks need: T_world_camera becomes motion(stamp) * T_world_camera.
  /// What is being reconstructed has them as they were: collect(true) before. O(frames).
  void moveFrames(const std::function<Pose(Stamp)>& motion);

  /// Forgets frames and tracks, after what is being reconstructed, which is thrown away. Ids go on.
  void reset();

  /// Ids of primitives from now on are above this one.
  void continueIdsAfter(PrimitiveId id) { next_id_.value = std::max(next_id_.value, id.value + 1); }

  /// How many tracks gave no primitive, by reason.
  const std::map<std::string, std::size_t>& rejections() const { return rejections_; }
  mapping::FrameBufferCounters frameCounters() const;
  /// Of all segmented frames that are kept, for live tracks or for such as wait.
  std::size_t aliveBytes() const { return *alive_bytes_; }
  std::size_t numPending() const { return pool_.numPending(); }
  /// Tracks ever submitted, reconstructed, and taken; from any thread.
  std::uint64_t numSubmitted() const { return num_submitted_; }
  std::uint64_t numDone() const { return pool_.numDone(); }
  std::uint64_t numCollected() const { return num_collected_; }

 private:
  /// A live or waiting track's provisional primitive.
  struct Provisional {
    PrimitiveId id;
    std::size_t num_observations = 0;  ///< that it was made from
    bool has_ended = false;            ///< the final one is being made
  };

  mapping::FrameBuffer& framesOf(std::uint32_t epoch);
  void makeRoom();
  void submit(const Track& track, const mapping::FrameBuffer& frames, bool is_provisional);
  void submitProvisional(const TrackedFrame& tracked, const mapping::FrameBuffer& frames);
  void withdrawVanished(const TrackedFrame& tracked);
  void endEpoch(std::map<std::uint32_t, mapping::FrameBuffer>::iterator epoch);
  void addFinal(mapping::PooledResult result, ObjectUpdate& update);
  void addProvisional(mapping::PooledResult result, ObjectUpdate& update);
  PrimitiveId takeId();

  ObjectFusionConfig config_;
  std::shared_ptr<std::atomic<std::size_t>> alive_bytes_;
  std::map<std::uint32_t, mapping::FrameBuffer> frames_;  ///< by epoch
  mapping::FrameBufferCounters former_frames_;            ///< of epochs that are over
  mapping::ObjectReconstructor reconstructor_;
  mapping::ReconstructionPool pool_;
  PrimitiveId next_id_{1};
  std::map<TrackId, Provisional> provisional_;
  std::set<TrackId> live_;  ///< by the newest message
  std::vector<PrimitiveId> withdrawn_;
  std::map<std::string, std::size_t> rejections_;
  std::atomic<std::uint64_t> num_submitted_{0};
  std::atomic<std::uint64_t> num_collected_{0};
};

}  // namespace tsg::pipeline
