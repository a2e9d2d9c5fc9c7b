// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/stage_times.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tsg {
namespace {

double computeNearestRank(const std::vector<double>& sorted, double quantile) {
  const auto rank =
      static_cast<std::size_t>(std::ceil(quantile * static_cast<double>(sorted.size())));
  return sorted[std::max<std::size_t>(rank, 1) - 1];
}

TimeSummary summarizeTimes(std::vector<double> times_ms) {
  std::sort(times_ms.begin(), times_ms.end());
  TimeSummary summary;
  summary.count = times_ms.size();
  summary.mean_ms =
      std::accumulate(times_ms.begin(), times_ms.end(), 0.0) / static_cast<double>(times_ms.size());
  summary.p50_ms = computeNearestRank(times_ms, 0.50);
  summary.p95_ms = computeNearestRank(times_ms, 0.95);
  summary.max_ms = times_ms.back();
  return summary;
}

}  // namespace

std::map<std::string, TimeSummary> StageTimes::summarize() const {
  std::map<std::string, TimeSummary> summaries;
  for (const auto& [stage, times_ms] : times_ms_) summaries[stage] = summarizeTimes(times_ms);
  return summaries;
}

}  // namespace tsg
