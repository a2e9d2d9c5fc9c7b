// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "task_scene_graph/ros/source_image.h"

namespace tsg::ros_interface {

/// Brings colour and depth images together by stamp: each colour image gets the depth image nearest
/// in time, if no other colour image is nearer to that one and both lie within the tolerance. Each
/// image is used once; whatever finds no partner is reported. Images come in order of their stamps
/// in either stream, the streams in any order. Not thread-safe.
/// deviation: message_filters' ApproximateTime says nothing of what it leaves out.
class PairMatcher {
 public:
  struct Pair {
    SourceImage color;
    SourceImage depth;
  };
  struct Unmatched {
    SourceImage color;
    std::optional<double> nearest_s;  ///< to the nearest depth image there was; none: no depth yet
  };
  /// What one step has decided, in order of the stamps.
  struct Outcome {
    std::vector<Pair> pairs;
    std::vector<Unmatched> unmatched_colors;
    std::size_t unmatched_depths = 0;
  };

  /// @param capacity  images of each stream that may wait; beyond it the oldest is decided on.
  PairMatcher(double tolerance_s, std::size_t capacity);

  Outcome addColor(SourceImage image);
  Outcome addDepth(SourceImage image);
  /// Decides on everything that waits, as if nothing more would come.
  Outcome flush();
  /// Forgets everything; returns how many colour images waited.
  std::size_t clear();
  std::size_t numWaiting() const { return colors_.size(); }

 private:
  void decide(bool is_end, Outcome& outcome);
  /// True if the front colour image was decided on.
  bool decideFront(bool is_end, Outcome& outcome);
  std::optional<std::size_t> findNearestDepth(Stamp stamp) const;
  bool belongsToNextColor(std::size_t depth) const;
  void pairFront(std::size_t depth, Outcome& outcome);
  void forgetDepths(std::size_t count, Outcome& outcome);
  std::optional<double> distanceToNearest(Stamp stamp) const;

  const double tolerance_s_;
  const std::size_t capacity_;
  std::deque<SourceImage> colors_;  ///< ascending by stamp
  std::deque<SourceImage> depths_;  ///< ascending by stamp
  std::optional<Stamp> last_gone_depth_;
};

}  // namespace tsg::ros_interface
