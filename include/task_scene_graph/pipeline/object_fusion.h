// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
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

/// From finished tracks to object primitives: keeps the segmented frames that live tracks need and
/// reconstructs each track from them once it has ended [Clio24, Sec. IV-A]. Frames are shared,
/// never copied. Not thread-safe: one worker owns it.
class ObjectFusion {
 public:
  explicit ObjectFusion(const ObjectFusionConfig& config);

  /// Keeps a segmented frame; must be given before the tracker's answer to it.
  void addFrame(const RgbdFramePtr& frame, const SegmentationPtr& segmentation);

  /// Begins to reconstruct the tracks that have ended, on threads of its own, and lets go of the
  /// frames that no live track needs. Returns at once unless `max_pending_tracks` wait.
  void submitTracks(const TrackedFrame& tracked);

  /// The primitives that are done since the last call; ids ascend in the order of submission, those
  /// of one frame in the order of their tracks' ids, whatever the number of threads. Tracks of
  /// which nothing can be reconstructed are counted by reason.
  /// @param wait  until all that was submitted is done.
  std::vector<ObjectPrimitivePtr> takePrimitives(bool wait);

  /// submitTracks(), then takePrimitives(true).
  std::vector<ObjectPrimitivePtr> addTracks(const TrackedFrame& tracked);

  /// How many tracks gave no primitive, by reason.
  const std::map<std::string, std::size_t>& rejections() const { return rejections_; }
  const mapping::FrameBuffer& frames() const { return frames_; }
  std::size_t numPending() const { return pool_.numPending(); }

 private:
  mapping::FrameBuffer frames_;
  mapping::ObjectReconstructor reconstructor_;
  mapping::ReconstructionPool pool_;
  PrimitiveId next_id_{1};
  std::map<std::string, std::size_t> rejections_;
};

}  // namespace tsg::pipeline
