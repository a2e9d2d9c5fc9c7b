// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <QObject>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>

namespace tsg::rviz_plugin {

/// Runs jobs one after the other in a thread of its own, and hands their results to the GUI's
/// thread: calls of services and of the master, which may block for ever, never hold up rviz.
///
/// A job may outlive this object, so it must own what it uses.
class BackgroundJobs {
 public:
  using Job = std::function<void()>;
  /// Queues what the GUI's thread should do, unless this object is gone meanwhile. From any thread.
  using Deliver = std::function<void(Job)>;

  /// @param receiver  lives in the GUI's thread, and longer than this object
  explicit BackgroundJobs(QObject* receiver);
  /// Drops the jobs that wait. One that runs is waited for at most half a second, then left alone.
  ~BackgroundJobs();

  void run(Job job);
  const Deliver& deliver() const { return deliver_; }

 private:
  struct State {
    std::mutex mutex;  ///< guards the rest
    std::condition_variable changed;
    std::deque<Job> jobs;
    bool is_stopped = false;
    bool has_ended = false;
  };

  static void work(const std::shared_ptr<State>& state);

  std::shared_ptr<State> state_ = std::make_shared<State>();
  Deliver deliver_;
};

}  // namespace tsg::rviz_plugin
