// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "task_scene_graph/ros/patience.h"

namespace tsg::ros_interface {

/// One thread that owns a stage: callbacks queue items, the thread handles them one by one, in
/// order. Items may drop: at most `capacity` of them wait, beyond it the oldest goes; with capacity
/// 1 it is a mailbox in which the newest item wins. Orders never drop, however many wait; items and
/// orders keep their common order. The handler must not throw.
template <typename Item>
class Worker {
 public:
  using Handler = std::function<void(Item)>;
  using DropHandler = std::function<void(const Item&)>;

  /// @param on_drop  is told of each item that is dropped, in the thread that pushes; may be empty.
  Worker(std::size_t capacity, Handler handler, DropHandler on_drop = {})
      : capacity_(capacity),
        handler_(std::move(handler)),
        on_drop_(std::move(on_drop)),
        thread_([this] { run(); }) {}
  /// Drops what is queued and joins the thread once it is done with the item in hand.
  ~Worker() { stop(); }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// Never blocks for long. Returns how many items were dropped to make room (0 or 1). From any
  /// thread.
  std::size_t push(Item item) {
    std::optional<Item> dropped;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (is_stopped_) return 1;
      if (num_items_ >= capacity_) dropped = dropOldestItem();
      queue_.push_back({std::move(item), ++num_pushed_, true});
      ++num_items_;
    }
    changed_.notify_all();
    if (dropped && on_drop_) on_drop_(*dropped);
    return dropped ? 1 : 0;
  }

  /// Queues what must not drop. False if the worker was stopped. From any thread.
  bool pushOrder(Item order) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (is_stopped_) return false;
      queue_.push_back({std::move(order), ++num_pushed_, false});
    }
    changed_.notify_all();
    return true;
  }

  /// Waits until nothing is queued and the thread rests. False if the deadline passes first.
  bool waitIdle(std::chrono::steady_clock::time_point deadline) {
    std::unique_lock<std::mutex> lock(mutex_);
    return changed_.wait_until(lock, deadline, [this] { return isIdle(); });
  }
  /// Waits until what is queued now is handled, whatever follows. False as waitPatiently.
  /// @param progress  of the handler within one item, if it can tell
  bool waitHandled(const Patience& patience, const std::function<std::uint64_t()>& progress = {}) {
    const std::uint64_t last = numPushed();
    return waitPatiently([&] { return isHandled(last); },
                         [&] { return numDone() + (progress ? progress() : 0); }, patience);
  }

  std::size_t size() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return queue_.size() + (is_busy_ ? 1 : 0);
  }

  /// Items and orders that were handled or dropped so far.
  std::uint64_t numDone() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return num_done_;
  }

  /// As the destructor; for owners whose handler uses members that die before the worker.
  void stop() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      is_stopped_ = true;
      num_done_ += queue_.size();
      queue_.clear();
      num_items_ = 0;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

 private:
  struct Entry {
    Item item;
    std::uint64_t number = 0;
    bool may_drop = true;
  };

  bool isIdle() const { return queue_.empty() && !is_busy_; }

  std::uint64_t numPushed() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return num_pushed_;
  }

  bool isHandled(std::uint64_t number) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return newest_handled_ >= number || isIdle();
  }

  // O(orders that wait before it).
  Item dropOldestItem() {
    const auto oldest = std::find_if(queue_.begin(), queue_.end(),
                                     [](const Entry& entry) { return entry.may_drop; });
    Item item = std::move(oldest->item);
    queue_.erase(oldest);
    --num_items_;
    ++num_done_;
    return item;
  }

  void run() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return is_stopped_ || !queue_.empty(); });
      if (is_stopped_) return;
      Entry entry = std::move(queue_.front());
      queue_.pop_front();
      num_items_ -= entry.may_drop ? 1 : 0;
      is_busy_ = true;
      lock.unlock();
      handler_(std::move(entry.item));
      lock.lock();
      is_busy_ = false;
      newest_handled_ = entry.number;
      ++num_done_;
      changed_.notify_all();
    }
  }

  const std::size_t capacity_;
  const Handler handler_;
  const DropHandler on_drop_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Entry> queue_;
  std::size_t num_items_ = 0;  ///< in queue_, that may drop
  std::uint64_t num_pushed_ = 0;
  std::uint64_t num_done_ = 0;        ///< handled or dropped
  std::uint64_t newest_handled_ = 0;  ///< number
  bool is_busy_ = false;
  bool is_stopped_ = false;
  std::thread thread_;
};

}  // namespace tsg::ros_interface
