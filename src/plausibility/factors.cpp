// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "consistency.h"

namespace tsg::plausibility {

FactorRange findFactors(const std::vector<ViewGroup>& groups, const Hypothesis& reading) {
  constexpr int kSteps = 24;  // of 5 %: a factor of 3.2 to both sides
  std::vector<Hypothesis> near{Hypothesis{}};
  for (int i = -kSteps; i <= kSteps; ++i) {
    near.push_back(reading);
    near.back().depth_factor = reading.depth_factor * std::pow(1.05, i);
  }
  DisagreementTable table(near);
  table.update(groups);
  double least = 1.0;
  for (std::size_t i = 1; i < near.size(); ++i) least = std::min(least, table.meanCost(i));
  FactorRange range{0.0, 0.0};
  for (std::size_t i = 1; i < near.size(); ++i) {
    if (table.meanCost(i) > least + 0.01) continue;
    if (range.low == 0.0) range.low = near[i].depth_factor;
    range.high = near[i].depth_factor;
  }
  return range;
}

}  // namespace tsg::plausibility
