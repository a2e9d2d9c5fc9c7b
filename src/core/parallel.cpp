// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/parallel.h"

#include <atomic>
#include <exception>
#include <mutex>
#include <opencv2/core/utility.hpp>

namespace tsg {

void parallelFor(std::size_t count, int num_threads, const std::function<void(std::size_t)>& body) {
  if (num_threads <= 1 || count <= 1) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  std::atomic<std::size_t> next{0};
  std::exception_ptr error;
  std::mutex error_mutex;
  const auto work = [&](const cv::Range&) {
    try {
      for (std::size_t i = next++; i < count; i = next++) body(i);
    } catch (...) {
      const std::lock_guard<std::mutex> lock(error_mutex);
      if (!error) error = std::current_exception();
      next = count;
    }
  };
  cv::parallel_for_(cv::Range(0, num_threads), work, num_threads);
  if (error) std::rethrow_exception(error);
}

}  // namespace tsg
