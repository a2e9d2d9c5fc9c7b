// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "agglomeration.h"
#include "primitive_graph.h"

namespace tsg::bottleneck {

using ComponentIndex = std::uint32_t;

/// A connected component of the primitives with its merge tape and where the tape is cut.
struct Component {
  std::vector<Slot> nodes;              ///< ascending by key; the tape's indices count along it
  MergeTape tape;                       ///< to the end, whatever the threshold
  std::vector<std::int64_t> worst;      ///< largest cost of tape[0..i], ascends with i
  std::size_t cut = 0;                  ///< merges applied: tape[0..cut)
  std::vector<std::uint32_t> clusters;  ///< entries of the registry, by ascending smallest key
  bool is_alive = false;
};

/// For each node of a component the smallest node of its cluster, after the first `cut` merges.
/// O(nodes).
std::vector<std::uint32_t> findClusterRoots(const Component& component);

/// All components [Clio24, App. B]. A merge is accepted by its cost alone, so the batch run over
/// the whole graph stops where each component's own run stops: cutting each tape is exact.
class ComponentSet {
 public:
  ComponentIndex insert(std::vector<Slot> nodes, MergeTape tape);
  /// Takes a component out.
  Component release(ComponentIndex index);
  /// Cuts every tape at its first cost that is not below `limit`; returns the components whose cut
  /// moved, ascending. O(components that move x log): the others are not looked at.
  std::vector<ComponentIndex> recut(std::int64_t limit);

  const Component& operator[](ComponentIndex index) const { return table_[index]; }
  void setClusters(ComponentIndex index, std::vector<std::uint32_t> clusters);
  /// One past the largest index in use; entries may be dead.
  ComponentIndex tableSize() const { return static_cast<ComponentIndex>(table_.size()); }
  std::size_t size() const { return table_.size() - free_.size(); }

 private:
  using Bound = std::pair<std::int64_t, ComponentIndex>;
  void enlist(ComponentIndex index);
  void delist(ComponentIndex index);

  std::vector<Component> table_;
  std::vector<ComponentIndex> free_;
  std::set<Bound> next_costs_;     // of the first merge not applied
  std::set<Bound> applied_costs_;  // worst of the merges applied
};

}  // namespace tsg::bottleneck
