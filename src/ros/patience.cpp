// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/patience.h"

#include <thread>

namespace tsg::ros_interface {

Patience Patience::from(double timeout_s, double quiet_s) {
  const auto toDuration = [](double seconds) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  };
  return {Clock::now() + toDuration(timeout_s), toDuration(quiet_s)};
}

bool waitPatiently(const std::function<bool()>& is_done,
                   const std::function<std::uint64_t()>& progress, const Patience& patience) {
  std::uint64_t newest = progress();
  auto newest_change = Patience::Clock::now();
  while (!is_done()) {
    const auto now = Patience::Clock::now();
    const std::uint64_t current = progress();
    if (current != newest) newest_change = now;
    newest = current;
    if (now >= patience.deadline || now - newest_change >= patience.quiet) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

}  // namespace tsg::ros_interface
