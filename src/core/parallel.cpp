// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/parallel.h"

#include <atomic>
#include <exception>
#include <mutex>
#include <opencv2/core/utility.hpp>
#include <thread>
#include <vector>

namespace tsg {
namespace {

#ifdef __SANITIZE_THREAD__
/// Threads of our own: ThreadSanitizer does not see how OpenCV's pool, which is not instrumented,
/// hands over work, and would report what is no race.
void runOnThreads(int num_threads, const std::function<void()>& work) {
  std::vector<std::thread> threads;
  for (int i = 1; i < num_threads; ++i) threads.emplace_back(work);
  work();
  for (auto& thread : threads) thread.join();
}
#else
void runOnThreads(int num_threads, const std::function<void()>& work) {
  cv::parallel_for_(
      cv::Range(0, num_threads), [&](const cv::Range&) { work(); }, num_threads);
}
#endif

}  // namespace

void parallelFor(std::size_t count, int num_threads, const std::function<void(std::size_t)>& body) {
  if (num_threads <= 1 || count <= 1) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  std::atomic<std::size_t> next{0};
  std::exception_ptr error;
  std::mutex error_mutex;
  const auto work = [&] {
    try {
      for (std::size_t i = next++; i < count; i = next++) body(i);
    } catch (...) {
      const std::lock_guard<std::mutex> lock(error_mutex);
      if (!error) error = std::current_exception();
      next = count;
    }
  };
  runOnThreads(num_threads, work);
  if (error) std::rethrow_exception(error);
}

}  // namespace tsg
