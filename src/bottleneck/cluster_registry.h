// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <unordered_set>
#include <utility>
#include <vector>

#include "component_set.h"
#include "task_scene_graph/core/set_names.h"

namespace tsg::bottleneck {

/// Names of clusters that outlive changes.
///
/// A former cluster's id goes to the cluster that now holds most of its primitives (equal: the one
/// with the smallest key); a cluster that could take several ids takes that of which it holds most
/// (equal: the smallest id). But clusters of exactly the primitives of one of before have their id
/// again, unless it would go to a cluster that has none of its own. Clusters left without an id get
/// new ones, ascending with their smallest key. So the ids follow from the sequence of changes, a
/// threshold turned there and back gives the same ids, and no id goes to primitives none of which
/// it ever named.
class ClusterRegistry {
 public:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  struct Entry {
    std::uint64_t id = 0;  ///< 0: not in use
    ComponentIndex component = 0;
    std::uint32_t label = 0;  ///< position among the component's clusters
    std::uint32_t size = 0;   ///< primitives
  };

  struct Changes {
    std::vector<std::uint64_t> removed;  ///< ascending
    std::vector<std::uint64_t> changed;  ///< new, or with other primitives; ascending
  };

  /// Names the clusters of `components` anew. `former`: entries of the clusters that they, and
  /// components that are no more, had; `is_rerun`: by component, whether all its clusters count as
  /// changed. O(primitives in `components`).
  Changes assign(const std::vector<ComponentIndex>& components, const std::vector<bool>& is_rerun,
                 const std::vector<std::uint32_t>& former, const PrimitiveGraph& graph,
                 ComponentSet& component_set);
  /// Names clusters before the first is assigned: what holds these primitives from now on is
  /// theirs.
  /// @param clusters  ids ascending from 1, none of them in use; slots in one cluster at most
  /// @returns their entries, which are `former` of the next assign()
  std::vector<std::uint32_t> adopt(
      const std::vector<std::pair<std::uint64_t, std::vector<Slot>>>& clusters);
  /// Says that the primitive in a slot is no more.
  void forget(Slot slot);

  /// @throws std::out_of_range naming the id if there is no such cluster.
  const Entry& find(std::uint64_t id) const;
  bool contains(std::uint64_t id) const { return indexOf(id) != kNone; }
  const Entry& operator[](std::uint32_t index) const { return table_[index]; }
  /// Entry of the cluster that holds a primitive; kNone before it was first assigned.
  std::uint32_t clusterOf(Slot slot) const {
    return slot < cluster_of_.size() ? cluster_of_[slot] : kNone;
  }
  std::size_t size() const { return table_.size() - free_.size(); }

 private:
  struct Groups;
  // The new cluster that holds most of a former cluster's primitives, while they are counted.
  struct Heir {
    std::uint32_t shared = 0;  // with the group being counted
    std::uint32_t group = kNone;
    std::uint32_t most_shared = 0;
  };
  // The same, found.
  struct Legacy {
    std::uint32_t former;
    std::uint32_t group;
    std::uint32_t shared;
  };
  using Entries = std::unordered_set<std::uint32_t>;

  static Groups makeGroups(const std::vector<ComponentIndex>& components,
                           const std::vector<bool>& is_rerun, const ComponentSet& component_set);
  void findKnown(Groups& groups, const PrimitiveGraph& graph) const;
  std::vector<Legacy> findHeirs(const Groups& groups, const PrimitiveGraph& graph);
  void countShared(const Groups& groups, std::uint32_t group, std::vector<std::uint32_t>& seen);
  /// Returns the entries that were given to clusters of the same primitives as before.
  Entries claimKnown(Groups& groups, const std::vector<std::uint32_t>& former,
                     const std::vector<Legacy>& legacies);
  void claimFormer(Groups& groups, const std::vector<Legacy>& legacies, const Entries& taken);
  std::vector<std::uint64_t> dropUnclaimed(const std::vector<std::uint32_t>& former,
                                           const Groups& groups);
  void nameUnclaimed(Groups& groups, const PrimitiveGraph& graph);
  std::vector<std::uint64_t> commit(const Groups& groups, ComponentSet& component_set);
  std::uint32_t makeEntry();
  std::uint32_t takeFree(std::uint64_t id);
  std::uint32_t reviveEntry(std::uint64_t id);
  void dropStaleIds();
  std::uint32_t indexOf(std::uint64_t id) const;  // kNone if there is none

  std::vector<Entry> table_;
  std::vector<Heir> heirs_;  // beside table_
  std::vector<std::uint32_t> free_;
  std::vector<std::uint32_t> cluster_of_;  // by slot; apart from the primitives, for speed
  std::vector<std::pair<std::uint64_t, std::uint32_t>>
      issued_;                       // ids ascending, with their entries
  std::size_t issued_limit_ = 1024;  // of its size, before those that are no more are dropped
  std::uint64_t next_id_ = 1;
  SetNames names_{200000};  // ids by the keys of what they named: 10 MB
};

}  // namespace tsg::bottleneck
