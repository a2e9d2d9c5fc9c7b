// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/bottleneck/distribution.h"

#include <algorithm>
#include <cmath>

namespace tsg::bottleneck {
namespace {

constexpr double kBitsPerNat = 1.4426950408889634074;
constexpr double kResolution = 2e-15;  // of D relative to h(n_a, n_b): some ulp per shared task

}  // namespace

double computeEntropyBits(const SparseMasses& distribution) {
  double bits = 0.0;
  for (const TaskMass& entry : distribution) bits -= entry.mass * std::log2(entry.mass);
  return std::max(bits, 0.0);
}

SparseMasses addMasses(const SparseMasses& a, const SparseMasses& b) {
  SparseMasses sum;
  sum.reserve(std::max(a.size(), b.size()));
  auto i = a.begin();
  auto j = b.begin();
  while (i != a.end() || j != b.end()) {
    if (j == b.end() || (i != a.end() && i->task < j->task)) {
      sum.push_back(*i++);
    } else if (i == a.end() || j->task < i->task) {
      sum.push_back(*j++);
    } else {
      sum.push_back({i->task, i++->mass + j++->mass});
    }
  }
  return sum;
}

SparseMasses toDistribution(const SparseMasses& masses) {
  double total = 0.0;
  for (const TaskMass& entry : masses) total += entry.mass;
  SparseMasses distribution = masses;
  for (TaskMass& entry : distribution) entry.mass /= total;
  return distribution;
}

double computeMixingBits(double a, double b) {
  const double small = std::min(a, b);
  const double large = std::max(a, b);
  if (!(small > 0.0)) return 0.0;
  const double ratio = small / large;
  const double log_sum = std::log1p(ratio) * kBitsPerNat;
  return large * log_sum + small * (log_sum - std::log2(ratio));
}

double computeMergeCost(const SparseMasses& a, double count_a, const SparseMasses& b,
                        double count_b) {
  const double unrelated = computeMixingBits(count_a, count_b);
  double shared = 0.0;
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (i->task < j->task) {
      ++i;
    } else if (j->task < i->task) {
      ++j;
    } else {
      shared += computeMixingBits(i++->mass, j++->mass);
    }
  }
  const double cost = unrelated - shared;
  return cost > kResolution * unrelated ? cost : 0.0;
}

std::int64_t roundCost(double cost) { return std::llround(cost / kCostUnit); }

}  // namespace tsg::bottleneck
