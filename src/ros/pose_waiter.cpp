// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/pose_waiter.h"

#include <tf2/exceptions.h>

#include <chrono>
#include <sstream>
#include <stdexcept>

#include "task_scene_graph/ros/geometry_conversions.h"

namespace tsg::ros_interface {
namespace {

/// How often timeouts are looked at when tf is silent.
constexpr auto kPollInterval = std::chrono::milliseconds(50);

}  // namespace

PoseWaiter::PoseWaiter(tf2::BufferCore& buffer, Options options, std::function<double()> now_s,
                       OnFrame on_frame, OnDrop on_drop)
    : buffer_(buffer),
      options_(std::move(options)),
      now_s_(std::move(now_s)),
      on_frame_(std::move(on_frame)),
      on_drop_(std::move(on_drop)) {
  tf_changed_ = buffer_._addTransformsChangedListener([this] {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      has_news_ = true;
    }
    changed_.notify_all();
  });
  thread_ = std::thread([this] { run(); });
}

PoseWaiter::~PoseWaiter() {
  tf_changed_.disconnect();
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
  on_drop_(Reason::kQueueFull,
           "too many frames wait for their pose; of the oldest: " + lookUp(*dropped).value_or("-"));
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
  const std::optional<std::string> why_not = lookUp(waiting);
  if (why_not) {
    const bool expired = now_s_() - waiting.arrival_s > options_.timeout_s;
    if (!expired && !isTooLate(waiting)) return false;
  }
  queue_.pop_front();
  lock.unlock();
  if (why_not) {
    on_drop_(Reason::kNoTransform, *why_not);
  } else {
    on_frame_(waiting.frame);
  }
  lock.lock();
  return true;
}

std::optional<std::string> PoseWaiter::lookUp(const Waiting& waiting) const {
  try {
    waiting.frame->T_world_camera =
        toPose(buffer_
                   .lookupTransform(options_.world_frame, waiting.camera_frame,
                                    toRosTime(waiting.frame->stamp))
                   .transform);
    return std::nullopt;
  } catch (const std::exception& e) {
    std::ostringstream text;
    text.precision(3);
    text << std::fixed << "no transform from '" << waiting.camera_frame << "' to '"
         << options_.world_frame << "' at stamp " << waiting.frame->stamp.seconds()
         << " s: " << e.what();
    return text.str();
  }
}

bool PoseWaiter::isTooLate(const Waiting& waiting) const {
  try {
    const auto newest =
        buffer_.lookupTransform(options_.world_frame, waiting.camera_frame, ::ros::Time(0));
    return waiting.frame->stamp < toStamp(newest.header.stamp);
  } catch (const tf2::TransformException&) {
    return false;
  }
}

}  // namespace tsg::ros_interface
