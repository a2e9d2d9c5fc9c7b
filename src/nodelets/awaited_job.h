// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <string>

namespace tsg::nodelets {

/// A job of one thread that another waits for, and that may refer to what the other one owns: once
/// the wait is over the job runs no more.
class AwaitedJob {
 public:
  /// Runs the job, unless nobody waits any more.
  template <typename Job>
  void run(const Job& job) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (state_ == State::kAbandoned) return;
      state_ = State::kRunning;
    }
    std::exception_ptr error;
    try {
      job();
    } catch (...) {
      error = std::current_exception();
    }
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      error_ = error;
      state_ = State::kDone;
    }
    changed_.notify_all();
  }

  /// Waits for the job; one that has begun is waited for however long it takes.
  /// @throws what the job throws; std::runtime_error if it has not begun in time: it never will.
  void wait(std::chrono::seconds timeout) {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait_for(lock, timeout, [this] { return state_ == State::kDone; });
    if (state_ == State::kQueued) {
      state_ = State::kAbandoned;
      throw std::runtime_error("not done after " + std::to_string(timeout.count()) +
                               " s: what came before is still at work");
    }
    changed_.wait(lock, [this] { return state_ == State::kDone; });
    if (error_) std::rethrow_exception(error_);
  }

 private:
  enum class State { kQueued, kRunning, kDone, kAbandoned };

  std::mutex mutex_;  ///< guards the two below
  std::condition_variable changed_;
  State state_ = State::kQueued;
  std::exception_ptr error_;
};

}  // namespace tsg::nodelets
