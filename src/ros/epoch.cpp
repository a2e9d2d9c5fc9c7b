// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/epoch.h"

#include <algorithm>

namespace tsg::ros_interface {

void EpochFollower::startEpoch(Clock::time_point now) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++epoch_;
  newest_jump_ = now;
}

std::uint32_t EpochFollower::epoch() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return epoch_;
}

std::uint32_t EpochFollower::follow(std::uint32_t declared, Stamp stamp, Clock::time_point now) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (declared == 0) {
    counted_ += order_.update(stamp) == StampOrder::Kind::kJumpBack ? 1 : 0;
    declared = counted_;
  }
  const bool is_restarted = declared < newest_declared_;
  const std::int64_t agreed = static_cast<std::int64_t>(epoch_) - declared;
  if (!offset_ || is_restarted) offset_ = agreed;
  newest_declared_ = declared;
  if (*offset_ == agreed) {
    differs_since_.reset();
  } else if (!differs_since_) {
    differs_since_ = now;
  } else if (now - *differs_since_ > patience_ && now - newest_jump_ > patience_) {
    offset_ = agreed;
    differs_since_.reset();
  }
  return static_cast<std::uint32_t>(
      std::max<std::int64_t>(1, static_cast<std::int64_t>(declared) + *offset_));
}

}  // namespace tsg::ros_interface
