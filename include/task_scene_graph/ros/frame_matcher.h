// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>

#include "task_scene_graph/core/frame.h"

namespace tsg::ros_interface {

/// Brings frames and their segmentations together by exact stamp. Either may come first: a
/// segmentation is usually late, a frame may have to wait for its pose. Thread-safe.
class FrameMatcher {
 public:
  struct Match {
    RgbdFramePtr frame;
    SegmentationPtr segmentation;
  };

  /// Keeps at most `max_frames` frames (oldest out first) and as many segmentations.
  explicit FrameMatcher(std::size_t max_frames) : max_frames_(max_frames) {}

  /// Frames older than the match are forgotten: segmentations come in order.
  std::optional<Match> addFrame(RgbdFramePtr frame);
  /// @param epoch  of its stamps: one that is over is passed over, one that is still to come waits
  /// for startEpoch()
  std::optional<Match> addSegmentation(SegmentationPtr segmentation, std::uint32_t epoch = 1);
  /// Stamps start anew: forgets all that is not of this epoch. Counts from 1.
  void startEpoch(std::uint32_t epoch);
  /// Forgets everything.
  void clear();

  /// Segmentations that went without ever finding their frame.
  std::uint64_t numUnmatchedSegmentations() const;
  std::size_t numFrames() const;

 private:
  Match finish(RgbdFramePtr frame, SegmentationPtr segmentation);

  struct Waiting {
    SegmentationPtr segmentation;
    std::uint32_t epoch = 1;
  };

  const std::size_t max_frames_;
  mutable std::mutex mutex_;
  std::deque<RgbdFramePtr> frames_;    ///< ascending by stamp
  std::deque<Waiting> segmentations_;  ///< ascending by epoch and stamp
  std::uint32_t epoch_ = 1;
  std::uint64_t num_unmatched_ = 0;
};

}  // namespace tsg::ros_interface
