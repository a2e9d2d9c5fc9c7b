// SPDX-License-Identifier: BSD-3-Clause
#include "cluster_registry.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace tsg::bottleneck {
namespace {

constexpr std::uint32_t kNone = ClusterRegistry::kNone;

struct Group {
  ComponentIndex component;
  std::uint32_t label;
  bool is_rerun;
  Slot smallest;        // primitive with the smallest key
  std::uint32_t begin;  // its primitives: members[begin..end)
  std::uint32_t end;
  std::uint32_t entry;   // the name it takes over
  std::uint32_t shared;  // primitives in common with the former bearer of the name
  std::uint64_t keys;    // hash of its primitives' keys
  std::uint64_t known;   // id that these primitives had; 0: none
  bool is_back;          // and it has that again

  std::uint32_t size() const { return end - begin; }
};

}  // namespace

/// The clusters to be named.
struct ClusterRegistry::Groups {
  std::vector<Group> list;
  std::vector<Slot> members;

  void append(ComponentIndex index, const Component& component, bool is_rerun);
};

void ClusterRegistry::Groups::append(ComponentIndex index, const Component& component,
                                     bool is_rerun) {
  const std::vector<std::uint32_t> roots = findClusterRoots(component);
  std::vector<std::uint32_t> group_of(roots.size());
  const auto first = static_cast<std::uint32_t>(list.size());
  for (std::uint32_t i = 0; i < roots.size(); ++i) {
    if (roots[i] == i) {
      const auto label = static_cast<std::uint32_t>(list.size()) - first;
      list.push_back({index, label, is_rerun, component.nodes[i], 0, 0, kNone, 0, 0, 0, false});
    }
    group_of[i] = roots[i] == i ? static_cast<std::uint32_t>(list.size()) - 1 : group_of[roots[i]];
    ++list[group_of[i]].end;
  }
  auto begin = static_cast<std::uint32_t>(members.size());
  for (std::size_t g = first; g < list.size(); ++g) {
    list[g].begin = begin;
    begin += list[g].end;
    list[g].end = list[g].begin;
  }
  members.resize(begin);
  for (std::uint32_t i = 0; i < roots.size(); ++i) {
    members[list[group_of[i]].end++] = component.nodes[i];
  }
}

ClusterRegistry::Groups ClusterRegistry::makeGroups(const std::vector<ComponentIndex>& components,
                                                    const std::vector<bool>& is_rerun,
                                                    const ComponentSet& component_set) {
  Groups groups;
  for (std::size_t i = 0; i < components.size(); ++i) {
    groups.append(components[i], component_set[components[i]], is_rerun[i]);
  }
  return groups;
}

void ClusterRegistry::findKnown(Groups& groups, const PrimitiveGraph& graph) const {
  for (Group& group : groups.list) {
    SetHash keys;
    for (std::uint32_t i = group.begin; i < group.end; ++i) keys.add(graph[groups.members[i]].key);
    group.keys = keys.value();
    group.known = names_.find(group.keys);
  }
}

ClusterRegistry::Entries ClusterRegistry::claimKnown(Groups& groups,
                                                     const std::vector<std::uint32_t>& former,
                                                     const std::vector<Legacy>& legacies) {
  Entries free(former.begin(), former.end());
  for (const Legacy& legacy : legacies) {  // such as go to a cluster that has no other id stay
    if (groups.list[legacy.group].known == 0) free.erase(legacy.former);
  }
  Entries taken;
  for (Group& group : groups.list) {
    if (group.known == 0) continue;
    const std::uint32_t entry = indexOf(group.known);
    if (entry != kNone && free.erase(entry) == 0) continue;
    group.is_back = true;
    group.entry = entry == kNone ? reviveEntry(group.known) : entry;
    taken.insert(group.entry);
    for (std::uint32_t i = group.begin; i < group.end; ++i) {
      if (clusterOf(groups.members[i]) == group.entry) ++group.shared;
    }
  }
  return taken;
}

void ClusterRegistry::countShared(const Groups& groups, std::uint32_t group,
                                  std::vector<std::uint32_t>& seen) {
  const Group& g = groups.list[group];
  for (std::uint32_t i = g.begin; i < g.end; ++i) {
    const std::uint32_t former = clusterOf(groups.members[i]);
    if (former == kNone) continue;
    if (heirs_[former].group == kNone && heirs_[former].shared == 0) seen.push_back(former);
    ++heirs_[former].shared;
  }
}

std::vector<ClusterRegistry::Legacy> ClusterRegistry::findHeirs(const Groups& groups,
                                                                const PrimitiveGraph& graph) {
  const auto keyOf = [&](const Group& group) { return graph[group.smallest].key; };
  std::vector<std::uint32_t> all_formers;
  const auto count = static_cast<std::uint32_t>(groups.list.size());
  for (std::uint32_t g = 0; g < count; ++g) {
    const Group& group = groups.list[g];
    countShared(groups, g, all_formers);
    for (std::uint32_t i = group.begin; i < group.end; ++i) {
      const std::uint32_t former = clusterOf(groups.members[i]);
      if (former == kNone || heirs_[former].shared == 0) continue;
      Heir& heir = heirs_[former];
      const bool is_better =
          heir.group == kNone || heir.shared > heir.most_shared ||
          (heir.shared == heir.most_shared && keyOf(group) < keyOf(groups.list[heir.group]));
      if (is_better) heir = {0, g, heir.shared};
      heir.shared = 0;
    }
  }
  std::vector<Legacy> legacies;
  for (const std::uint32_t former : all_formers) {
    const Heir heir = std::exchange(heirs_[former], Heir());
    legacies.push_back({former, heir.group, heir.most_shared});
  }
  return legacies;
}

void ClusterRegistry::claimFormer(Groups& groups, const std::vector<Legacy>& legacies,
                                  const Entries& taken) {
  for (const Legacy& legacy : legacies) {
    Group& group = groups.list[legacy.group];
    if (group.is_back || taken.count(legacy.former) > 0) continue;
    const bool is_better =
        group.entry == kNone || legacy.shared > group.shared ||
        (legacy.shared == group.shared && table_[legacy.former].id < table_[group.entry].id);
    if (!is_better) continue;
    group.entry = legacy.former;
    group.shared = legacy.shared;
  }
}

std::vector<std::uint64_t> ClusterRegistry::dropUnclaimed(const std::vector<std::uint32_t>& former,
                                                          const Groups& groups) {
  for (const Group& group : groups.list) {
    if (group.entry != kNone) heirs_[group.entry].shared = 1;
  }
  std::vector<std::uint64_t> removed;
  for (const std::uint32_t entry : former) {
    if (heirs_[entry].shared == 0) {
      removed.push_back(table_[entry].id);
      table_[entry] = Entry();
      free_.push_back(entry);
    }
    heirs_[entry].shared = 0;
  }
  for (const Group& group : groups.list) {
    if (group.entry != kNone) heirs_[group.entry].shared = 0;
  }
  std::sort(removed.begin(), removed.end());
  return removed;
}

std::uint32_t ClusterRegistry::takeFree(std::uint64_t id) {
  if (free_.empty()) {
    free_.push_back(static_cast<std::uint32_t>(table_.size()));
    table_.emplace_back();
    heirs_.emplace_back();
  }
  const std::uint32_t entry = free_.back();
  free_.pop_back();
  table_[entry].id = id;
  return entry;
}

std::uint32_t ClusterRegistry::makeEntry() {
  const std::uint32_t entry = takeFree(next_id_++);
  issued_.emplace_back(table_[entry].id, entry);
  if (issued_.size() > issued_limit_) dropStaleIds();
  return entry;
}

std::uint32_t ClusterRegistry::reviveEntry(std::uint64_t id) {
  const std::uint32_t entry = takeFree(id);
  const auto place = std::lower_bound(issued_.begin(), issued_.end(), std::make_pair(id, 0u));
  if (place != issued_.end() && place->first == id) {
    place->second = entry;
  } else {
    issued_.insert(place, {id, entry});
  }
  return entry;
}

void ClusterRegistry::dropStaleIds() {
  const auto is_gone = [this](const auto& issued) {
    return table_[issued.second].id != issued.first;
  };
  issued_.erase(std::remove_if(issued_.begin(), issued_.end(), is_gone), issued_.end());
  issued_limit_ = 2 * issued_.size() + 1024;
}

std::uint32_t ClusterRegistry::indexOf(std::uint64_t id) const {
  const auto place = std::lower_bound(issued_.begin(), issued_.end(), std::make_pair(id, 0u));
  const bool is_found =
      place != issued_.end() && place->first == id && table_[place->second].id == id;
  return is_found ? place->second : kNone;
}

void ClusterRegistry::nameUnclaimed(Groups& groups, const PrimitiveGraph& graph) {
  std::vector<std::pair<NodeKey, std::size_t>> unnamed;
  for (std::size_t g = 0; g < groups.list.size(); ++g) {
    const Group& group = groups.list[g];
    if (group.entry == kNone) unnamed.emplace_back(graph[group.smallest].key, g);
  }
  std::sort(unnamed.begin(), unnamed.end());
  for (const auto& [key, g] : unnamed) groups.list[g].entry = makeEntry();
}

std::vector<std::uint64_t> ClusterRegistry::commit(const Groups& groups,
                                                   ComponentSet& component_set) {
  std::vector<std::uint64_t> changed;
  std::vector<std::uint32_t> entries;  // of one component
  for (std::size_t g = 0; g < groups.list.size(); ++g) {
    const Group& group = groups.list[g];
    Entry& entry = table_[group.entry];
    const bool is_same =
        !group.is_rerun && group.shared == group.size() && group.shared == entry.size;
    if (!is_same) changed.push_back(entry.id);
    if (!is_same) names_.remember(group.keys, entry.id);
    entry = {entry.id, group.component, group.label, group.size()};
    for (std::uint32_t i = group.begin; i < group.end; ++i) {
      cluster_of_[groups.members[i]] = group.entry;
    }
    entries.push_back(group.entry);
    const bool is_last =
        g + 1 == groups.list.size() || groups.list[g + 1].component != group.component;
    if (is_last) component_set.setClusters(group.component, std::exchange(entries, {}));
  }
  std::sort(changed.begin(), changed.end());
  return changed;
}

ClusterRegistry::Changes ClusterRegistry::assign(const std::vector<ComponentIndex>& components,
                                                 const std::vector<bool>& is_rerun,
                                                 const std::vector<std::uint32_t>& former,
                                                 const PrimitiveGraph& graph,
                                                 ComponentSet& component_set) {
  if (cluster_of_.size() < graph.tableSize()) cluster_of_.resize(graph.tableSize(), kNone);
  Groups groups = makeGroups(components, is_rerun, component_set);
  findKnown(groups, graph);
  const std::vector<Legacy> legacies = findHeirs(groups, graph);
  claimFormer(groups, legacies, claimKnown(groups, former, legacies));
  Changes changes;
  changes.removed = dropUnclaimed(former, groups);
  nameUnclaimed(groups, graph);
  changes.changed = commit(groups, component_set);
  return changes;
}

std::vector<std::uint32_t> ClusterRegistry::adopt(
    const std::vector<std::pair<std::uint64_t, std::vector<Slot>>>& clusters) {
  std::vector<std::uint32_t> entries;
  for (const auto& [id, slots] : clusters) {
    if (id < next_id_) {
      throw std::invalid_argument("cluster " + std::to_string(id) + ", expected ids from " +
                                  std::to_string(next_id_) + " on, ascending");
    }
    next_id_ = id;
    entries.push_back(makeEntry());
    for (const Slot slot : slots) {
      if (cluster_of_.size() <= slot) cluster_of_.resize(slot + 1, kNone);
      cluster_of_[slot] = entries.back();
    }
  }
  return entries;
}

void ClusterRegistry::forget(Slot slot) {
  if (slot < cluster_of_.size()) cluster_of_[slot] = kNone;
}

const ClusterRegistry::Entry& ClusterRegistry::find(std::uint64_t id) const {
  const std::uint32_t index = indexOf(id);
  if (index != kNone) return table_[index];
  throw std::out_of_range("there is no cluster " + std::to_string(id));
}

}  // namespace tsg::bottleneck
