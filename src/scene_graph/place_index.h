// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "task_scene_graph/core/primitives.h"

namespace tsg::scene_graph {

/// Where each place of a graph is: a table where ids are dense, as they are while mapping, else a
/// search. Precondition: ids ascend. The graph may change its places' contents, not their ids.
class PlaceIndex {
 public:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  PlaceIndex() = default;
  explicit PlaceIndex(const PlaceGraph& graph) {
    ids_.reserve(graph.places.size());
    for (const Place& place : graph.places) ids_.push_back(place.id.value);
    constexpr std::size_t kMaxSparsity = 16;
    if (ids_.empty() || ids_.back() > kMaxSparsity * ids_.size()) return;
    table_.assign(ids_.back() + 1, kNone);
    for (std::size_t i = 0; i < ids_.size(); ++i) table_[ids_[i]] = i;
  }

  /// Position in `graph.places`; kNone if the id is not there.
  std::size_t find(PlaceId id) const {
    if (!table_.empty()) return id.value < table_.size() ? table_[id.value] : kNone;
    const auto found = std::lower_bound(ids_.begin(), ids_.end(), id.value);
    const bool is_there = found != ids_.end() && *found == id.value;
    return is_there ? static_cast<std::size_t>(found - ids_.begin()) : kNone;
  }

 private:
  std::vector<std::uint64_t> ids_;
  std::vector<std::size_t> table_;  ///< by id; empty where ids are sparse
};

}  // namespace tsg::scene_graph
