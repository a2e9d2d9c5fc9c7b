// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/pose_waiter.h"

#include <chrono>

namespace tsg::ros_interface {
namespace {

/// How often timeouts are looked at when tf is silent.
constexpr auto kPollInterval = std::chrono::milliseconds(50);

}  // namespace

PoseWaiter::PoseWaiter(const PoseSource& poses, Options options, std::function<double()> now_s,
                       OnFrame on_frame, OnDrop on_drop)
    : poses_(poses),
      options_(options),
      now_s_(std::move(now_s)),
      on_frame_(std::move(on_frame)),
      on_drop_(std::move(on_drop)) {
  thread_ = std::thread([this] { run(); });
}

PoseWaiter::~PoseWaiter() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_stopped_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void PoseWaiter::push(std::shared_ptr<RgbdFrame> frame, const std::string& camera_frame) {
  std::optional<Waiting> dropped;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (queue_.size() >= options_.capacity) {
      dropped = queue_.front();
      queue_.pop_front();
    }
    queue_.push_back({std::move(frame), camera_frame, now_s_()});
    has_news_ = true;
  }
  changed_.notify_all();
  if (!dropped) return;
  on_drop_(kQueueFull, "too many frames wait for their pose; of the oldest: " +
                           poses_.lookUp(dropped->camera_frame, dropped->frame->stamp).why_not);
}

void PoseWaiter::notifyNews() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    has_news_ = true;
  }
  changed_.notify_all();
}

std::size_t PoseWaiter::clear() {
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::size_t count = queue_.size();
  queue_.clear();
  return count;
}

std::size_t PoseWaiter::size() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return queue_.size();
}

void PoseWaiter::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!is_stopped_) {
    changed_.wait_for(lock, kPollInterval, [this] { return is_stopped_ || has_news_; });
    has_news_ = false;
    while (!is_stopped_ && advance(lock)) {
    }
  }
}

bool PoseWaiter::advance(std::unique_lock<std::mutex>& lock) {
  if (queue_.empty()) return false;
  const Waiting waiting = queue_.front();
  const auto answer = poses_.lookUp(waiting.camera_frame, waiting.frame->stamp);
  const bool is_expired = now_s_() - waiting.arrival_s > options_.timeout_s;
  if (!answer.T_world_camera && !answer.is_final && !is_expired) return false;
  queue_.pop_front();
  lock.unlock();
  if (answer.T_world_camera) {
    waiting.frame->T_world_camera = *answer.T_world_camera;
    on_frame_(waiting.frame);
  } else {
    on_drop_(answer.reason, answer.why_not);
  }
  lock.lock();
  return true;
}

}  // namespace tsg::ros_interface
