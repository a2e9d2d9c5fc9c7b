// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace tsg {

/// Summary of how long a stage took, milliseconds of wall time.
struct TimeSummary {
  std::size_t count = 0;
  double mean_ms = 0.0;
  double p50_ms = 0.0;
  double p95_ms = 0.0;
  double max_ms = 0.0;
};

/// Wall times of named stages, for reports only: no result depends on them. Not thread-safe.
class StageTimes {
 public:
  /// Runs `action`, adds its duration to `stage` and returns what it returns.
  template <typename Action>
  auto measure(const std::string& stage, Action&& action) {
    const Timer timer{*this, stage, Clock::now()};
    return std::forward<Action>(action)();
  }

  void add(const std::string& stage, double duration_ms) {
    times_ms_[stage].push_back(duration_ms);
  }

  /// By name. Quantiles are of the nearest rank. O(n log n).
  std::map<std::string, TimeSummary> summarize() const;

 private:
  using Clock = std::chrono::steady_clock;

  struct Timer {
    StageTimes& times;
    const std::string& stage;
    Clock::time_point start;
    ~Timer() {
      times.add(stage, std::chrono::duration<double, std::milli>(Clock::now() - start).count());
    }
  };

  std::map<std::string, std::vector<double>> times_ms_;
};

}  // namespace tsg
