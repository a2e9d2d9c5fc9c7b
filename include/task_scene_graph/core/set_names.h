// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <unordered_map>

#include "task_scene_graph/core/mix_bits.h"

namespace tsg {

/// Hash of a set of ids, whatever their order: add() each once. Two sets of 64-bit ids have the
/// same one by chance only (2^-64 for each pair).
class SetHash {
 public:
  void add(std::uint64_t id) { sum_ += mixBits(id); }
  std::uint64_t value() const { return mixBits(sum_); }

 private:
  std::uint64_t sum_ = 0;
};

/// Which name each set of things had last, so that a set that forms again, as when a threshold is
/// turned there and back, has its name again. Not thread-safe.
class SetNames {
 public:
  /// @param max_sets  beyond it the ones remembered first are forgotten
  explicit SetNames(std::size_t max_sets) : max_sets_(max_sets) {}

  /// @param set  its SetHash; O(1)
  void remember(std::uint64_t set, std::uint64_t name) {
    if (!names_.insert_or_assign(set, name).second) return;
    order_.push_back(set);
    if (order_.size() <= max_sets_) return;
    names_.erase(order_.front());
    order_.pop_front();
  }
  /// 0 if it has none. O(1)
  std::uint64_t find(std::uint64_t set) const {
    const auto found = names_.find(set);
    return found == names_.end() ? 0 : found->second;
  }

 private:
  std::size_t max_sets_;
  std::unordered_map<std::uint64_t, std::uint64_t> names_;  ///< by set
  std::deque<std::uint64_t> order_;                         ///< of the sets, first remembered first
};

}  // namespace tsg
