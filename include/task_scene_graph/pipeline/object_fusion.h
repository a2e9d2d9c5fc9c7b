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

namespace tsg::pipeline {

struct ObjectFusionConfig {
  mapping::FrameBufferConfig frame_buffer;
  mapping::ObjectConfig reconstruction;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.group("frame_buffer", self.frame_buffer);
    v.group("reconstruction", self.reconstruction);
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

  /// Reconstructs the tracks that have ended and lets go of the frames that no live track needs.
  /// Tracks of which nothing can be reconstructed are counted by reason. Ids ascend in the order of
  /// the tracks' ids.
  std::vector<ObjectPrimitivePtr> addTracks(const TrackedFrame& tracked);

  /// How many tracks gave no primitive, by reason.
  const std::map<std::string, std::size_t>& rejections() const { return rejections_; }
  const mapping::FrameBuffer& frames() const { return frames_; }

 private:
  mapping::FrameBuffer frames_;
  mapping::ObjectReconstructor reconstructor_;
  PrimitiveId next_id_{1};
  std::map<std::string, std::size_t> rejections_;
};

}  // namespace tsg::pipeline
