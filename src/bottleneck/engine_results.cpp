// SPDX-License-Identifier: BSD-3-Clause
// What callers are given: clusters, updates, the merges of all components as one sequence.
#include <algorithm>
#include <queue>
#include <set>
#include <tuple>
#include <utility>

#include "engine.h"

namespace tsg::bottleneck {

Cluster ClusteringEngine::makeCluster(std::uint32_t entry, const std::vector<Slot>& members) {
  Cluster cluster;
  cluster.id = registry_[entry].id;
  cluster.members.reserve(members.size());
  dense_.assign(static_cast<std::size_t>(scorer_.numTasks()) + 1, 0.0);
  for (const Slot slot : members) {
    cluster.members.push_back(graph_[slot].key);
    for (const TaskMass& entry_y : graph_[slot].relevance) dense_[entry_y.task] += entry_y.mass;
  }
  const auto best = std::max_element(dense_.begin(), dense_.end());
  cluster.task = static_cast<int>(best - dense_.begin());
  for (std::uint32_t y = 0; y < dense_.size(); ++y) {
    if (dense_[y] > 0.0) cluster.relevance.push_back({y, dense_[y]});
  }
  cluster.relevance = toDistribution(cluster.relevance);
  return cluster;
}

void ClusteringEngine::appendClusters(ComponentIndex index, std::vector<Cluster>& clusters) {
  const Component& component = components_[index];
  std::vector<std::vector<Slot>> members(component.clusters.size());
  for (const Slot slot : component.nodes) {
    members[registry_[registry_.clusterOf(slot)].label].push_back(slot);
  }
  for (std::size_t label = 0; label < members.size(); ++label) {
    clusters.push_back(makeCluster(component.clusters[label], members[label]));
  }
}

std::vector<Cluster> ClusteringEngine::makeClusters() {
  std::vector<Cluster> clusters;
  clusters.reserve(registry_.size());
  for (ComponentIndex index = 0; index < components_.tableSize(); ++index) {
    if (components_[index].is_alive) appendClusters(index, clusters);
  }
  std::sort(clusters.begin(), clusters.end(),
            [](const Cluster& a, const Cluster& b) { return a.id < b.id; });
  changed_.clear();
  removed_.clear();
  return clusters;
}

ClusteringUpdate ClusteringEngine::takeUpdate() {
  compactChanged();
  std::set<ComponentIndex> touched;
  for (const std::uint64_t id : changed_) touched.insert(registry_.find(id).component);
  ClusteringUpdate update;
  for (const ComponentIndex index : touched) appendClusters(index, update.changed);
  const auto is_old = [this](const Cluster& cluster) {
    return !std::binary_search(changed_.begin(), changed_.end(), cluster.id);
  };
  update.changed.erase(std::remove_if(update.changed.begin(), update.changed.end(), is_old),
                       update.changed.end());
  std::sort(update.changed.begin(), update.changed.end(),
            [](const Cluster& a, const Cluster& b) { return a.id < b.id; });
  update.removed = std::exchange(removed_, {});
  std::sort(update.removed.begin(), update.removed.end());
  changed_.clear();
  return update;
}

std::vector<Merge> ClusteringEngine::makeMergeSequence() const {
  using Head = std::tuple<std::int64_t, NodeKey, NodeKey, ComponentIndex, std::size_t>;
  std::priority_queue<Head, std::vector<Head>, std::greater<>> heads;
  const auto push = [&](ComponentIndex index, std::size_t i) {
    const Component& component = components_[index];
    if (i >= component.cut) return;
    const MergeStep& step = component.tape[i];
    heads.emplace(step.cost, graph_[component.nodes[step.a]].key,
                  graph_[component.nodes[step.b]].key, index, i);
  };
  for (ComponentIndex index = 0; index < components_.tableSize(); ++index) push(index, 0);
  const MergeRule rule(config_, totalBits());
  const double count = static_cast<double>(graph_.size());
  std::vector<Merge> merges;
  while (!heads.empty()) {
    const auto [cost, a, b, index, i] = heads.top();
    heads.pop();
    merges.push_back(
        {a, b, static_cast<double>(cost) * kCostUnit / count, rule.computeDelta(cost)});
    push(index, i + 1);
  }
  return merges;
}

}  // namespace tsg::bottleneck
