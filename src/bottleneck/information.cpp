// SPDX-License-Identifier: BSD-3-Clause
#include "information.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tsg::bottleneck {
namespace {

constexpr double kCoarseSteps = 1073741824.0;  // 2^30
constexpr std::int64_t kNoLimit = std::numeric_limits<std::int64_t>::max();

}  // namespace

void ExactSum::accumulate(double value, std::int64_t sign) {
  const double coarse = std::nearbyint(value * kCoarseSteps);
  const double rest = value - coarse / kCoarseSteps;
  coarse_ += sign * static_cast<std::int64_t>(coarse);
  fine_ += sign * static_cast<std::int64_t>(std::nearbyint(rest * kCoarseSteps * kCoarseSteps));
}

double ExactSum::value() const {
  return static_cast<double>(coarse_) / kCoarseSteps +
         static_cast<double>(fine_) / (kCoarseSteps * kCoarseSteps);
}

void InformationSum::accumulate(const SparseMasses& relevance, bool is_added) {
  const auto apply = [is_added](ExactSum& sum, double value) {
    is_added ? sum.add(value) : sum.subtract(value);
  };
  count_ += is_added ? 1 : -1;
  apply(entropies_, computeEntropyBits(relevance));
  for (const TaskMass& entry : relevance) {
    if (entry.task >= marginals_.size()) marginals_.resize(entry.task + 1);
    apply(marginals_[entry.task], entry.mass);
  }
}

double InformationSum::computeTotalBits(Prior prior, int num_tasks) const {
  const double count = static_cast<double>(count_);
  if (prior == Prior::kUniform) {
    return std::max(count * std::log2(num_tasks + 1.0) - entropies_.value(), 0.0);
  }
  double bits = -entropies_.value();  // + N H(p(y))
  for (const ExactSum& marginal : marginals_) {
    const double mass = marginal.value();
    if (mass > 0.0) bits += mass * std::log2(count / mass);
  }
  return std::max(bits, 0.0);
}

MergeRule::MergeRule(const ClusteringConfig& config, double total_bits)
    : threshold_(config.threshold()),
      bits_per_delta_(config.normaliser == Normaliser::kPaper ? total_bits : 2.0),
      limit_(findLimit()) {}

double MergeRule::computeDelta(std::int64_t cost) const {
  if (cost == 0 || !(bits_per_delta_ > 0.0)) return 0.0;
  return static_cast<double>(cost) * kCostUnit / bits_per_delta_;
}

std::int64_t MergeRule::findLimit() const {
  if (threshold_ <= 0.0) return 0;
  if (threshold_ >= 1.0 || !(bits_per_delta_ > 0.0)) return kNoLimit;
  auto limit = std::max(std::llround(threshold_ * bits_per_delta_ / kCostUnit), 1LL);
  while (computeDelta(limit) < threshold_) ++limit;
  while (limit > 1 && !(computeDelta(limit - 1) < threshold_)) --limit;
  return limit;
}

}  // namespace tsg::bottleneck
