// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <tf2/buffer_core.h>

#include <boost/signals2/connection.hpp>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "task_scene_graph/core/frame.h"

namespace tsg::ros_interface {

/// Keeps frames, in order, until tf knows the camera's pose at their stamp. Nobody is blocked: a
/// thread of its own looks whenever tf has changed.
class PoseWaiter {
 public:
  enum class Reason { kNoTransform, kQueueFull };
  struct Options {
    std::string world_frame = "world";
    std::size_t capacity = 100;  ///< frames; a full queue drops its oldest
    double timeout_s = 1.0;      ///< on the clock given
  };
  using OnFrame = std::function<void(RgbdFramePtr)>;
  /// `text` says which transform at which stamp was missing and why.
  using OnDrop = std::function<void(Reason, const std::string& text)>;

  /// `now_s` is the clock of the timeout, seconds. Both callbacks come from this object's thread
  /// (kQueueFull: from the caller of push) and must not throw.
  PoseWaiter(tf2::BufferCore& buffer, Options options, std::function<double()> now_s,
             OnFrame on_frame, OnDrop on_drop);
  ~PoseWaiter();
  PoseWaiter(const PoseWaiter&) = delete;
  PoseWaiter& operator=(const PoseWaiter&) = delete;

  /// The frame's pose is still to be set. Never blocks for long.
  void push(std::shared_ptr<RgbdFrame> frame, const std::string& camera_frame);
  /// Forgets all frames that wait; returns how many.
  std::size_t clear();
  std::size_t size() const;

 private:
  struct Waiting {
    std::shared_ptr<RgbdFrame> frame;
    std::string camera_frame;
    double arrival_s = 0.0;
  };

  void run();
  /// Deals with the oldest frame if it can be decided. The lock is released around callbacks.
  bool advance(std::unique_lock<std::mutex>& lock);
  /// Sets the pose; else says why not.
  std::optional<std::string> lookUp(const Waiting& waiting) const;
  /// True if tf is already past the stamp: waiting longer is of no use.
  bool isTooLate(const Waiting& waiting) const;

  tf2::BufferCore& buffer_;
  const Options options_;
  const std::function<double()> now_s_;
  const OnFrame on_frame_;
  const OnDrop on_drop_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Waiting> queue_;
  bool has_news_ = false;
  bool is_stopped_ = false;
  boost::signals2::scoped_connection tf_changed_;
  std::thread thread_;
};

}  // namespace tsg::ros_interface
