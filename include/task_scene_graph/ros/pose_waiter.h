// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/ros/pose_source.h"

namespace tsg::ros_interface {

/// Keeps frames, in order, until the camera's pose at their stamp is known. Nobody is blocked: a
/// thread of its own looks whenever there is news.
class PoseWaiter {
 public:
  struct Options {
    std::size_t capacity = 100;  ///< frames; a full queue drops its oldest
    double timeout_s = 1.0;      ///< on the clock given
  };
  using OnFrame = std::function<void(RgbdFramePtr)>;
  /// `reason` is PoseSource's, or kQueueFull; `text` says which pose at which stamp was missing and
  /// why.
  using OnDrop = std::function<void(const std::string& reason, const std::string& text)>;
  static constexpr const char* kQueueFull = "pose queue full";

  /// `now_s` is the clock of the timeout, seconds. Both callbacks come from this object's thread
  /// (kQueueFull: from the caller of push) and must not throw.
  /// `poses` must live longer.
  PoseWaiter(const PoseSource& poses, Options options, std::function<double()> now_s,
             OnFrame on_frame, OnDrop on_drop);
  ~PoseWaiter();
  PoseWaiter(const PoseWaiter&) = delete;
  PoseWaiter& operator=(const PoseWaiter&) = delete;

  /// The frame's pose is still to be set. Never blocks for long.
  void push(std::shared_ptr<RgbdFrame> frame, const std::string& camera_frame);
  /// New transforms or poses have come. From any thread.
  void notifyNews();
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

  const PoseSource& poses_;
  const Options options_;
  const std::function<double()> now_s_;
  const OnFrame on_frame_;
  const OnDrop on_drop_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Waiting> queue_;
  bool has_news_ = false;
  bool is_stopped_ = false;
  std::thread thread_;
};

}  // namespace tsg::ros_interface
