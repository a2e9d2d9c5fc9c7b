// SPDX-License-Identifier: BSD-3-Clause
#include "background_jobs.h"

#include <chrono>
#include <thread>
#include <utility>

namespace tsg::rviz_plugin {

BackgroundJobs::BackgroundJobs(QObject* receiver) {
  deliver_ = [state = state_, receiver](Job job) {
    const std::lock_guard<std::mutex> lock(state->mutex);
    if (state->is_stopped) return;
    QMetaObject::invokeMethod(
        receiver,
        [state, job = std::move(job)] {
          {
            const std::lock_guard<std::mutex> inner_lock(state->mutex);
            if (state->is_stopped) return;
          }
          job();
        },
        Qt::QueuedConnection);
  };
  std::thread([state = state_] { work(state); }).detach();
}

BackgroundJobs::~BackgroundJobs() {
  std::unique_lock<std::mutex> lock(state_->mutex);
  state_->is_stopped = true;
  state_->jobs.clear();
  state_->changed.notify_all();
  state_->changed.wait_for(lock, std::chrono::milliseconds(500),
                           [this] { return state_->has_ended; });
}

void BackgroundJobs::run(Job job) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->jobs.push_back(std::move(job));
  state_->changed.notify_all();
}

void BackgroundJobs::work(const std::shared_ptr<State>& state) {
  std::unique_lock<std::mutex> lock(state->mutex);
  while (true) {
    state->changed.wait(lock, [&] { return state->is_stopped || !state->jobs.empty(); });
    if (state->is_stopped) break;
    const Job job = std::move(state->jobs.front());
    state->jobs.pop_front();
    lock.unlock();
    job();
    lock.lock();
  }
  state->has_ended = true;
  state->changed.notify_all();
}

}  // namespace tsg::rviz_plugin
