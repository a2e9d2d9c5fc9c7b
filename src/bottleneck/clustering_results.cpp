// SPDX-License-Identifier: BSD-3-Clause
// What callers are given: clusters, updates, the merges of all components as one sequence.
#include <algorithm>
#include <queue>
#include <set>
#include <tuple>
#include <utility>

#include "clustering_state.h"

namespace tsg::bottleneck {

Cluster ClusteringState::makeCluster(std::uint32_t entry, const std::vector<Slot>& members) {
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

void ClusteringState::appendClusters(ComponentIndex index, std::vector<Cluster>& clusters) {
  const Component& component = components_[index];
  std::vector<std::vector<Slot>> members(component.clusters.size());
  for (const Slot slot : component.nodes) {
    members[registry_[registry_.clusterOf(slot)].label].push_back(slot);
  }
  for (std::size_t label = 0; label < members.size(); ++label) {
    clusters.push_back(makeCluster(component.clusters[label], members[label]));
  }
}

std::vector<Cluster> IncrementalClustering::clusters() {
  state_->apply();
  std::vector<Cluster> clusters;
  clusters.reserve(state_->registry_.size());
  for (ComponentIndex index = 0; index < state_->components_.tableSize(); ++index) {
    if (state_->components_[index].is_alive) state_->appendClusters(index, clusters);
  }
  std::sort(clusters.begin(), clusters.end(),
            [](const Cluster& a, const Cluster& b) { return a.id < b.id; });
  state_->changed_.clear();
  state_->removed_.clear();
  return clusters;
}

ClusteringUpdate IncrementalClustering::applyChanges() {
  state_->apply();
  state_->compactChanged();
  std::set<ComponentIndex> touched;
  for (const std::uint64_t id : state_->changed_)
    touched.insert(state_->registry_.find(id).component);
  ClusteringUpdate update;
  for (const ComponentIndex index : touched) state_->appendClusters(index, update.changed);
  const auto is_old = [this](const Cluster& cluster) {
    return !std::binary_search(state_->changed_.begin(), state_->changed_.end(), cluster.id);
  };
  update.changed.erase(std::remove_if(update.changed.begin(), update.changed.end(), is_old),
                       update.changed.end());
  std::sort(update.changed.begin(), update.changed.end(),
            [](const Cluster& a, const Cluster& b) { return a.id < b.id; });
  update.removed = std::exchange(state_->removed_, {});
  std::sort(update.removed.begin(), update.removed.end());
  state_->changed_.clear();
  return update;
}

std::vector<Merge> IncrementalClustering::mergeSequence() {
  state_->apply();
  using Head = std::tuple<std::int64_t, NodeKey, NodeKey, ComponentIndex, std::size_t>;
  std::priority_queue<Head, std::vector<Head>, std::greater<>> heads;
  const auto push = [&](ComponentIndex index, std::size_t i) {
    const Component& component = state_->components_[index];
    if (i >= component.cut) return;
    const MergeStep& step = component.tape[i];
    heads.emplace(step.cost, state_->graph_[component.nodes[step.a]].key,
                  state_->graph_[component.nodes[step.b]].key, index, i);
  };
  for (ComponentIndex index = 0; index < state_->components_.tableSize(); ++index) push(index, 0);
  const MergeRule rule = state_->rule();
  const double count = static_cast<double>(state_->graph_.size());
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

std::uint64_t IncrementalClustering::clusterOf(NodeKey key) {
  const Slot slot = state_->graph_.find(key);
  state_->apply();
  return state_->registry_[state_->registry_.clusterOf(slot)].id;
}

std::vector<double> IncrementalClustering::scores(NodeKey key) {
  const Slot slot = state_->graph_.find(key);
  state_->apply();
  return state_->graph_[slot].scores;
}

SparseMasses IncrementalClustering::relevance(NodeKey key) {
  const Slot slot = state_->graph_.find(key);
  state_->apply();
  return state_->graph_[slot].relevance;
}

std::pair<SparseMasses, std::size_t> IncrementalClustering::sumRelevance(
    const std::vector<NodeKey>& keys) {
  state_->apply();
  std::vector<double> dense(static_cast<std::size_t>(state_->scorer_.numTasks()) + 1, 0.0);
  std::size_t count = 0;
  for (const NodeKey key : keys) {
    const std::optional<Slot> slot = state_->graph_.findIfThere(key);
    if (!slot) continue;
    for (const TaskMass& mass : state_->graph_[*slot].relevance) dense[mass.task] += mass.mass;
    ++count;
  }
  SparseMasses sum;
  for (std::uint32_t y = 0; y < dense.size(); ++y) {
    if (dense[y] > 0.0) sum.push_back({y, dense[y]});
  }
  return {sum, count};
}

double IncrementalClustering::information() {
  state_->apply();
  return size() == 0 ? 0.0 : state_->totalBits() / static_cast<double>(size());
}

}  // namespace tsg::bottleneck
