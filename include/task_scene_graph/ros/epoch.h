// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>

#include "task_scene_graph/core/stamp.h"
#include "task_scene_graph/ros/stamp_order.h"

namespace tsg::ros_interface {

/// Which of a stage's epochs a message of another stage belongs to.
///
/// Stamps that jump back (a bag in a loop) begin a new epoch. Each stage notices that in the images
/// that it gets, and counts; its messages say its count. Two stages notice one after the other, and
/// may have been started at different times: what counts is by how much their counts differ, which
/// the first message tells. A stream that does not say its epoch (a recorded segmentation) is
/// counted by its own stamps. Thread-safe.
class EpochFollower {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param patience  for so long after a jump, messages of the epoch before may arrive, or those
  /// of the new one before the jump itself is noticed; afterwards the two counts are brought
  /// together again
  explicit EpochFollower(Clock::duration patience = std::chrono::seconds(10))
      : patience_(patience) {}

  /// Own stamps have jumped back.
  void startEpoch(Clock::time_point now = Clock::now());
  /// Own epoch, from 1.
  std::uint32_t epoch() const;

  /// The own epoch of a message, in the order of the stream; may lie ahead of epoch().
  /// @param declared  by the message; 0 = it says none
  std::uint32_t follow(std::uint32_t declared, Stamp stamp, Clock::time_point now = Clock::now());

 private:
  const Clock::duration patience_;
  mutable std::mutex mutex_;
  std::uint32_t epoch_ = 1;
  Clock::time_point newest_jump_;  ///< own
  std::optional<Clock::time_point> differs_since_;
  StampOrder order_;           ///< of a stream that does not say its epoch
  std::uint32_t counted_ = 1;  ///< ... and its epoch
  std::uint32_t newest_declared_ = 0;
  std::optional<std::int64_t> offset_;  ///< own minus the stream's
};

}  // namespace tsg::ros_interface
