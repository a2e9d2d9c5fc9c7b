// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "task_scene_graph/bottleneck/config.h"
#include "task_scene_graph/bottleneck/distribution.h"

namespace tsg::bottleneck {

/// Sum of doubles in steps of 2^-60, exact, so that it does not depend on the order of additions
/// and removals. For totals below 2^32 and fewer than 2^32 terms.
class ExactSum {
 public:
  void add(double value) { accumulate(value, 1); }
  void subtract(double value) { accumulate(value, -1); }
  double value() const;

 private:
  void accumulate(double value, std::int64_t sign);

  std::int64_t coarse_ = 0;  // in 2^-30
  std::int64_t fine_ = 0;    // in 2^-60
};

/// The map's information about the tasks, kept up primitive by primitive: the normaliser of Eq. 3.
/// The same primitives give the same value, bit for bit, in whatever order they came and went.
class InformationSum {
 public:
  void add(const SparseMasses& relevance) { accumulate(relevance, true); }
  void remove(const SparseMasses& relevance) { accumulate(relevance, false); }
  void clear() { *this = InformationSum(); }

  std::int64_t numPrimitives() const { return count_; }
  /// N I(X;Y) in bits times primitives, >= 0. O(1) for the uniform prior, O(M) for the marginal.
  double computeTotalBits(Prior prior, int num_tasks) const;

 private:
  void accumulate(const SparseMasses& relevance, bool is_added);

  std::int64_t count_ = 0;
  ExactSum entropies_;               // sum of H(p(y|x))
  std::vector<ExactSum> marginals_;  // by task: sum of p(y|x)
};

/// The threshold of a merge: decides on costs in kCostUnit.
class MergeRule {
 public:
  /// `total_bits` = N I(X;Y).
  MergeRule(const ClusteringConfig& config, double total_bits);

  /// What the threshold is compared with: delta(k) (Eq. 3) or delta_bits(k). Without information
  /// (total_bits 0) nothing can be lost: 0.
  double computeDelta(std::int64_t cost) const;
  /// computeDelta(cost) < threshold. Always false for a threshold of 0 (the primitives), always
  /// true for 1 (components whole).
  bool isAccepted(std::int64_t cost) const { return cost < limit_; }
  /// The smallest cost that is not accepted.
  std::int64_t limit() const { return limit_; }
  double threshold() const { return threshold_; }

 private:
  std::int64_t findLimit() const;

  double threshold_;
  double bits_per_delta_;
  std::int64_t limit_;
};

}  // namespace tsg::bottleneck
