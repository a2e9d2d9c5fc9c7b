// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>

#include "task_scene_graph/ros/patience.h"

namespace tsg::ros_interface {

/// How far a stage has received the messages of the stage before it, which numbers them from 1;
/// lets it wait for the rest. Thread-safe.
class Arrivals {
 public:
  void note(std::uint64_t sequence) { newest_ = sequence; }
  /// Waits until the message `sequence` (0: none) is there. False as waitPatiently.
  bool wait(std::uint64_t sequence, const Patience& patience) const {
    return waitPatiently([&] { return newest_ >= sequence; }, [&] { return newest_.load(); },
                         patience);
  }
  std::uint64_t newest() const { return newest_; }

 private:
  std::atomic<std::uint64_t> newest_{0};
};

}  // namespace tsg::ros_interface
