// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <unordered_set>

#include "task_scene_graph/core/stamp.h"

namespace tsg::ros_interface {

/// What a stage has received from the stage before it; lets a finishing stage wait for the rest.
class Arrivals {
 public:
  void noteId(std::uint64_t id) {
    const std::lock_guard<std::mutex> lock(mutex_);
    ids_.insert(id);
    changed_.notify_all();
  }
  void noteStamp(Stamp stamp) {
    const std::lock_guard<std::mutex> lock(mutex_);
    newest_ = stamp;
    changed_.notify_all();
  }
  /// Waits until the item `id` (0: none) and a message not older than `stamp` (0: any) are there.
  /// False if the deadline passes first.
  bool wait(std::uint64_t id, Stamp stamp, std::chrono::steady_clock::time_point deadline) {
    std::unique_lock<std::mutex> lock(mutex_);
    return changed_.wait_until(lock, deadline, [&] {
      return (id == 0 || ids_.count(id) > 0) && (stamp == Stamp{} || stamp <= newest_);
    });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::unordered_set<std::uint64_t> ids_;
  Stamp newest_;
};

}  // namespace tsg::ros_interface
