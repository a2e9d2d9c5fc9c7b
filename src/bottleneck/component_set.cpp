// SPDX-License-Identifier: BSD-3-Clause
#include "component_set.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace tsg::bottleneck {
namespace {

std::vector<std::int64_t> computeWorst(const MergeTape& tape) {
  std::vector<std::int64_t> worst;
  worst.reserve(tape.size());
  for (const MergeStep& step : tape) {
    worst.push_back(worst.empty() ? step.cost : std::max(worst.back(), step.cost));
  }
  return worst;
}

}  // namespace

std::vector<std::uint32_t> findClusterRoots(const Component& component) {
  std::vector<std::uint32_t> roots(component.nodes.size());
  std::iota(roots.begin(), roots.end(), 0u);
  for (std::size_t i = 0; i < component.cut; ++i) roots[component.tape[i].b] = component.tape[i].a;
  // A cluster is named by its smallest node, so parents come before their children.
  for (std::uint32_t& root : roots) root = roots[root];
  return roots;
}

ComponentIndex ComponentSet::insert(std::vector<Slot> nodes, MergeTape tape) {
  if (free_.empty()) {
    free_.push_back(tableSize());
    table_.emplace_back();
  }
  const ComponentIndex index = free_.back();
  free_.pop_back();
  Component& component = table_[index];
  component.nodes = std::move(nodes);
  component.worst = computeWorst(tape);
  component.tape = std::move(tape);
  component.is_alive = true;
  enlist(index);
  return index;
}

Component ComponentSet::release(ComponentIndex index) {
  delist(index);
  free_.push_back(index);
  return std::exchange(table_[index], Component());
}

void ComponentSet::enlist(ComponentIndex index) {
  const Component& component = table_[index];
  if (component.cut < component.tape.size()) {
    next_costs_.emplace(component.tape[component.cut].cost, index);
  }
  if (component.cut > 0) applied_costs_.emplace(component.worst[component.cut - 1], index);
}

void ComponentSet::delist(ComponentIndex index) {
  const Component& component = table_[index];
  if (component.cut < component.tape.size()) {
    next_costs_.erase({component.tape[component.cut].cost, index});
  }
  if (component.cut > 0) applied_costs_.erase({component.worst[component.cut - 1], index});
}

std::vector<ComponentIndex> ComponentSet::recut(std::int64_t limit) {
  std::vector<ComponentIndex> moved;
  for (const auto& [cost, index] : next_costs_) {
    if (cost >= limit) break;
    moved.push_back(index);
  }
  for (auto it = applied_costs_.rbegin(); it != applied_costs_.rend() && it->first >= limit; ++it) {
    moved.push_back(it->second);
  }
  std::sort(moved.begin(), moved.end());
  moved.erase(std::unique(moved.begin(), moved.end()), moved.end());
  for (const ComponentIndex index : moved) {
    delist(index);
    const auto& worst = table_[index].worst;
    const auto cut = std::lower_bound(worst.begin(), worst.end(), limit);
    table_[index].cut = static_cast<std::size_t>(cut - worst.begin());
    enlist(index);
  }
  return moved;
}

void ComponentSet::setClusters(ComponentIndex index, std::vector<std::uint32_t> clusters) {
  table_[index].clusters = std::move(clusters);
}

}  // namespace tsg::bottleneck
