// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/reconstruction_pool.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "task_scene_graph/core/thread_priority.h"

namespace tsg::mapping {

ReconstructionPool::ReconstructionPool(const ObjectReconstructor& reconstructor, int num_threads,
                                       std::size_t max_pending)
    : reconstructor_(reconstructor), max_pending_(std::max<std::size_t>(1, max_pending)) {
  for (int i = 0; i < std::max(1, num_threads); ++i) threads_.emplace_back([this] { work(); });
}

ReconstructionPool::~ReconstructionPool() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_stopped_ = true;
  }
  changed_.notify_all();
  for (auto& thread : threads_) thread.join();
}

void ReconstructionPool::submit(Track track, std::vector<SegmentedFrame> frames,
                                bool is_provisional) {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return pending_ < max_pending_; });
  jobs_.push_back({std::move(track), std::move(frames), {}, is_provisional, false});
  ++pending_;
  changed_.notify_all();
}

std::vector<PooledResult> ReconstructionPool::collectFinished() {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<PooledResult> results;
  while (!jobs_.empty() && jobs_.front().is_done) {
    Job& job = jobs_.front();
    results.push_back(
        {std::move(job.result), job.track.id, job.track.observations.size(), job.is_provisional});
    jobs_.pop_front();
    --started_;
  }
  return results;
}

std::vector<PooledResult> ReconstructionPool::collectAll() {
  {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return pending_ == 0; });
  }
  return collectFinished();
}

void ReconstructionPool::waitForProgress(std::chrono::milliseconds timeout) {
  std::unique_lock<std::mutex> lock(mutex_);
  const std::uint64_t done = num_done_;
  changed_.wait_for(lock, timeout, [&] { return pending_ == 0 || num_done_ != done; });
}

std::uint64_t ReconstructionPool::numDone() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return num_done_;
}

std::size_t ReconstructionPool::numPending() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return pending_;
}

void ReconstructionPool::work() {
  lowerThreadPriority();  // depth integration goes first
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return is_stopped_ || started_ < jobs_.size(); });
    if (is_stopped_) return;
    Job& job = jobs_[started_++];
    lock.unlock();
    ReconstructionResult result = reconstruct(job);
    std::vector<SegmentedFrame> used = std::move(job.frames);  // let go of without the lock
    used.clear();
    lock.lock();
    job.result = std::move(result);
    job.is_done = true;
    --pending_;
    ++num_done_;
    changed_.notify_all();
  }
}

ReconstructionResult ReconstructionPool::reconstruct(const Job& job) const {
  try {
    return reconstructor_.reconstruct(job.track, job.frames, PrimitiveId{});
  } catch (const std::exception&) {
    return {ReconstructionStatus::kBadFrames, nullptr};
  }
}

}  // namespace tsg::mapping
