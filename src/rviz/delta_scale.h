// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

namespace tsg::rviz_plugin {

/// A slider's steps for thresholds of merging: 0 is 0, then 1e-7 to 1, 100 steps for each power of
/// ten. On a linear scale all that happens would lie in the first hundredth.
class DeltaScale {
 public:
  static constexpr int kSteps = 701;

  static double toDelta(int step) {
    return step <= 0 ? 0.0 : std::pow(10.0, -7.0 + 0.01 * (std::min(step, kSteps) - 1));
  }
  /// The nearest step.
  static int toStep(double delta) {
    if (!(delta > 0.0)) return 0;
    const double step = 1.0 + 100.0 * (std::log10(delta) + 7.0);
    return static_cast<int>(std::lround(std::clamp(step, 1.0, static_cast<double>(kSteps))));
  }
};

}  // namespace tsg::rviz_plugin
