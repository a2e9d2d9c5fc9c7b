// SPDX-License-Identifier: BSD-3-Clause
// Components: from what changes touched to merge tapes.
#include <algorithm>
#include <map>
#include <utility>

#include "clustering_state.h"

namespace tsg::bottleneck {

/// The primitives whose components have to be found anew, ascending by key.
std::vector<Slot> ClusteringState::dissolve(const PrimitiveGraph::Touched& touched) {
  std::vector<Slot> loose;
  for (const ComponentIndex index : touched.components) {
    const Component& component = dissolved_[index] = components_.release(index);
    for (const Slot slot : component.nodes) {
      if (graph_[slot].component != index) continue;  // erased meanwhile
      graph_[slot].component = kNoSlot;
      graph_[slot].former_component = index;
      loose.push_back(slot);
    }
    former_.insert(former_.end(), component.clusters.begin(), component.clusters.end());
  }
  for (const Slot slot : touched.slots) {
    const auto& primitive = graph_[slot];
    const bool is_new = primitive.is_alive && primitive.component == kNoSlot &&
                        primitive.former_component == kNoSlot;
    if (is_new) loose.push_back(slot);
  }
  const auto isBefore = [this](Slot a, Slot b) { return graph_[a].key < graph_[b].key; };
  if (!std::is_sorted(loose.begin(), loose.end(), isBefore)) {  // one component, newer keys: is
    std::sort(loose.begin(), loose.end(), isBefore);
  }
  return loose;
}

/// Each ascending by key, in which order `loose` is. Neighbours of loose primitives are loose.
std::vector<std::vector<Slot>> ClusteringState::findComponents(const std::vector<Slot>& loose) {
  std::uint32_t num_parts = 0;
  local_.resize(std::max<std::size_t>(local_.size(), graph_.tableSize()), kNoSlot);
  for (const Slot slot : loose) local_[slot] = kNoSlot;  // not reached yet
  for (const Slot seed : loose) {
    if (local_[seed] != kNoSlot) continue;
    const std::uint32_t part = num_parts++;
    std::vector<Slot> reached{seed};
    local_[seed] = part;
    while (!reached.empty()) {
      const Slot slot = reached.back();
      reached.pop_back();
      for (const Slot neighbour : graph_[slot].neighbours) {
        if (local_[neighbour] != kNoSlot) continue;
        local_[neighbour] = part;
        reached.push_back(neighbour);
      }
    }
  }
  std::vector<std::vector<Slot>> parts(num_parts);
  for (const Slot slot : loose) {
    std::vector<Slot>& nodes = parts[local_[slot]];
    local_[slot] = static_cast<std::uint32_t>(nodes.size());
    nodes.push_back(slot);
  }
  return parts;
}

AgglomerationProblem ClusteringState::makeProblem(const std::vector<Slot>& nodes) const {
  AgglomerationProblem problem;
  problem.relevance.reserve(nodes.size());
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    problem.relevance.push_back(&graph_[nodes[i]].relevance);
    for (const Slot neighbour : graph_[nodes[i]].neighbours) {
      if (i < local_[neighbour]) problem.edges.emplace_back(i, local_[neighbour]);
    }
  }
  return problem;
}

// The dissolved component that nearly all of these primitives were in, unchanged; none if following
// its tape would not pay.
const Component* ClusteringState::findFormer(const std::vector<Slot>& nodes) const {
  constexpr std::size_t kMinSize = 500;
  constexpr double kMinShare = 0.9;
  if (nodes.size() < kMinSize) return nullptr;
  std::map<ComponentIndex, std::size_t> counts;
  for (const Slot slot : nodes) {
    if (!graph_[slot].is_changed) ++counts[graph_[slot].former_component];
  }
  for (const auto& [index, count] : counts) {
    const auto place = dissolved_.find(index);
    if (place == dissolved_.end()) continue;
    const auto size = static_cast<double>(std::max(nodes.size(), place->second.nodes.size()));
    if (static_cast<double>(count) >= kMinShare * size) return &place->second;
  }
  return nullptr;
}

FormerRun ClusteringState::makeFormerRun(const Component& former,
                                         const std::vector<Slot>& nodes) const {
  FormerRun run;
  run.tape = former.tape;
  run.index_of.assign(former.nodes.size(), FormerRun::kGone);
  run.is_changed.assign(nodes.size(), true);
  for (std::uint32_t i = 0; i < former.nodes.size(); ++i) {
    const Slot slot = former.nodes[i];
    const bool was_there = graph_[slot].is_alive && graph_[slot].former_component != kNoSlot;
    if (!was_there) continue;
    const std::uint32_t present = local_[slot];
    if (present >= nodes.size() || nodes[present] != slot) continue;  // in another part now
    run.index_of[i] = present;
    run.is_changed[present] = graph_[slot].is_changed;
  }
  return run;
}

std::vector<ComponentIndex> ClusteringState::storeTapes(std::vector<std::vector<Slot>> parts,
                                                        std::vector<MergeTape> tapes) {
  std::vector<ComponentIndex> rerun;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::vector<Slot> nodes = parts[i];
    rerun.push_back(components_.insert(std::move(parts[i]), std::move(tapes[i])));
    for (const Slot slot : nodes) {
      graph_[slot].component = rerun.back();
      graph_[slot].former_component = kNoSlot;
      graph_[slot].is_changed = false;
    }
  }
  dissolved_.clear();
  return rerun;
}

}  // namespace tsg::bottleneck
