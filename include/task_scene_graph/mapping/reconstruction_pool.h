// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "task_scene_graph/mapping/object_reconstructor.h"

namespace tsg::mapping {

/// A track's result, and whether the track had ended.
struct PooledResult {
  ReconstructionResult result;
  TrackId track;
  std::size_t num_observations = 0;
  bool is_provisional = false;
};

/// Reconstructs objects on a few threads of its own, at a lower priority than the caller's (where
/// the system knows priorities of threads). Results come back in the order of submission and do not
/// depend on the number of threads. Submitting and taking: from one thread.
class ReconstructionPool {
 public:
  /// @param num_threads  at least 1.
  /// @param max_pending  at least 1: tracks submitted and not yet reconstructed.
  ReconstructionPool(const ObjectReconstructor& reconstructor, int num_threads,
                     std::size_t max_pending);
  /// Drops what has not begun.
  ~ReconstructionPool();
  ReconstructionPool(const ReconstructionPool&) = delete;
  ReconstructionPool& operator=(const ReconstructionPool&) = delete;

  /// Hands over a track with the frames of its observations (FrameBuffer::collect), kept
  /// alive until it is reconstructed. Waits while `max_pending` tracks are pending. Frames that the
  /// reconstructor rejects with an exception give the status kBadFrames.
  void submit(Track track, std::vector<SegmentedFrame> frames, bool is_provisional = false);

  /// What is done of the oldest tracks without a gap, each result once. Primitives have no id yet.
  std::vector<PooledResult> collectFinished();
  /// Waits until nothing is pending, then as collectFinished().
  std::vector<PooledResult> collectAll();
  /// Waits until a track is done that was not when it was called, nothing is pending, or the time
  /// is over.
  void waitForProgress(std::chrono::milliseconds timeout);

  /// Tracks submitted and not yet reconstructed.
  std::size_t numPending() const;
  /// Tracks ever reconstructed.
  std::uint64_t numDone() const;

 private:
  struct Job {
    Track track;
    std::vector<SegmentedFrame> frames;
    ReconstructionResult result;
    bool is_provisional = false;
    bool is_done = false;
  };

  void work();
  ReconstructionResult reconstruct(const Job& job) const;

  const ObjectReconstructor& reconstructor_;
  const std::size_t max_pending_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Job> jobs_;     ///< submitted, result not taken; references stay valid at the ends
  std::size_t started_ = 0;  ///< of jobs_, from the front: a thread has them or has done them
  std::size_t pending_ = 0;
  std::uint64_t num_done_ = 0;
  bool is_stopped_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace tsg::mapping
