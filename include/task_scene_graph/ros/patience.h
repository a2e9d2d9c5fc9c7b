// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>

namespace tsg::ros_interface {

/// How long to wait for something: who still works is not late.
struct Patience {
  using Clock = std::chrono::steady_clock;

  Clock::time_point deadline;
  Clock::duration quiet{std::chrono::seconds(10)};  ///< without any progress

  /// From now on.
  static Patience from(double timeout_s, double quiet_s);
};

/// Waits until `is_done` (true) or until the deadline passes, or `progress` does not change for
/// `quiet` (false). Both are asked every few milliseconds, in this thread.
bool waitPatiently(const std::function<bool()>& is_done,
                   const std::function<std::uint64_t()>& progress, const Patience& patience);

}  // namespace tsg::ros_interface
