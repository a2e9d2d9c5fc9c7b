// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace tsg::ros_interface {

/// One thread that owns a stage: callbacks queue items, the thread handles them one by one, in
/// order. The queue is bounded; a full one drops its oldest item. With capacity 1 it is a mailbox
/// in which the newest item wins. The handler must not throw.
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
      if (queue_.size() >= capacity_) {
        dropped = std::move(queue_.front());
        queue_.pop_front();
      }
      queue_.push_back(std::move(item));
    }
    changed_.notify_all();
    if (dropped && on_drop_) on_drop_(*dropped);
    return dropped ? 1 : 0;
  }

  /// Waits until nothing is queued and the thread rests. False if the deadline passes first.
  bool waitIdle(std::chrono::steady_clock::time_point deadline) {
    std::unique_lock<std::mutex> lock(mutex_);
    return changed_.wait_until(lock, deadline, [this] { return queue_.empty() && !is_busy_; });
  }

  std::size_t size() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return queue_.size() + (is_busy_ ? 1 : 0);
  }

  /// As the destructor; for owners whose handler uses members that die before the worker.
  void stop() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      is_stopped_ = true;
      queue_.clear();
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

 private:
  void run() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return is_stopped_ || !queue_.empty(); });
      if (is_stopped_) return;
      Item item = std::move(queue_.front());
      queue_.pop_front();
      is_busy_ = true;
      lock.unlock();
      handler_(std::move(item));
      lock.lock();
      is_busy_ = false;
      changed_.notify_all();
    }
  }

  const std::size_t capacity_;
  const Handler handler_;
  const DropHandler on_drop_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Item> queue_;
  bool is_busy_ = false;
  bool is_stopped_ = false;
  std::thread thread_;
};

}  // namespace tsg::ros_interface
