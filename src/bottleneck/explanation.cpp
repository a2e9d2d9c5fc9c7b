// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/bottleneck/explanation.h"

#include <algorithm>
#include <cmath>

#include "clustering_state.h"
#include "task_scene_graph/bottleneck/clustering.h"

namespace tsg::bottleneck {
namespace {

int findBestTask(const SparseMasses& masses) {
  const auto best = std::max_element(masses.begin(), masses.end(),
                                     [](TaskMass a, TaskMass b) { return a.mass < b.mass; });
  return best == masses.end() ? 0 : static_cast<int>(best->task);
}

// Replays the merges of one component.
class Replay {
 public:
  Replay(const ClusteringState& state, ComponentIndex index)
      : state_(state), component_(state.components()[index]), rule_(state.rule()) {
    for (const Slot slot : component_.nodes) {
      masses_.push_back(state.graph()[slot].relevance);
      parents_.push_back(static_cast<std::uint32_t>(parents_.size()));
    }
  }

  std::size_t position() const { return position_; }
  bool isAtEnd() const { return position_ == component_.tape.size(); }
  bool isAtCut() const { return position_ == component_.cut; }
  const MergeStep& next() const { return component_.tape[position_]; }

  /// The next merge, not yet done.
  ExplainedMerge explainNext() const {
    const MergeStep& step = next();
    ExplainedMerge merge;
    merge.a = keyOf(step.a);
    merge.b = keyOf(step.b);
    merge.d =
        static_cast<double>(step.cost) * kCostUnit / static_cast<double>(state_.graph().size());
    merge.delta = rule_.computeDelta(step.cost);
    merge.before_a = toDistribution(masses_[step.a]);
    merge.before_b = toDistribution(masses_[step.b]);
    merge.after = toDistribution(addMasses(masses_[step.a], masses_[step.b]));
    merge.task = findBestTask(merge.after);
    return merge;
  }

  void advance() {
    const MergeStep& step = next();
    masses_[step.a] = addMasses(masses_[step.a], masses_[step.b]);
    parents_[step.b] = step.a;
    ++position_;
  }

  std::uint32_t findRoot(std::uint32_t node) const {
    while (parents_[node] != node) node = parents_[node];
    return node;
  }

  std::uint32_t indexOf(NodeKey key) const {
    const auto place = std::lower_bound(
        component_.nodes.begin(), component_.nodes.end(), key,
        [this](Slot slot, NodeKey value) { return state_.graph()[slot].key < value; });
    return static_cast<std::uint32_t>(place - component_.nodes.begin());
  }

 private:
  NodeKey keyOf(std::uint32_t node) const { return state_.graph()[component_.nodes[node]].key; }

  const ClusteringState& state_;
  const Component& component_;
  MergeRule rule_;
  std::vector<SparseMasses> masses_;
  std::vector<std::uint32_t> parents_;
  std::size_t position_ = 0;
};

double computeClusterEntropy(const ClusteringState& state) {
  const double total = static_cast<double>(state.graph().size());
  double bits = 0.0;
  for (ComponentIndex index = 0; index < state.components().tableSize(); ++index) {
    for (const std::uint32_t entry : state.components()[index].clusters) {
      const double share = state.registry()[entry].size / total;
      bits -= share * std::log2(share);
    }
  }
  return std::max(bits, 0.0);
}

}  // namespace

ClusterExplanation IncrementalClustering::explainCluster(std::uint64_t id) {
  state_->apply();
  const ClusterRegistry::Entry& entry = state_->registry_.find(id);
  const Component& component = state_->components_[entry.component];
  const std::uint32_t index = component.clusters[entry.label];
  ClusterExplanation explanation;
  explanation.id = id;
  explanation.threshold = state_->rule().threshold();
  Replay replay(*state_, entry.component);
  for (; !replay.isAtCut(); replay.advance()) {
    const Slot slot = component.nodes[replay.next().a];
    if (state_->registry_.clusterOf(slot) == index)
      explanation.merges.push_back(replay.explainNext());
  }
  if (!replay.isAtEnd()) explanation.stop = replay.explainNext();
  SparseMasses masses;
  for (const Slot slot : component.nodes) {
    if (state_->registry_.clusterOf(slot) == index)
      masses = addMasses(masses, state_->graph_[slot].relevance);
  }
  explanation.task = findBestTask(masses);
  return explanation;
}

PairExplanation IncrementalClustering::explainPair(NodeKey a, NodeKey b) {
  state_->apply();
  const Slot x = state_->graph_.find(a);
  const Slot z = state_->graph_.find(b);
  PairExplanation explanation;
  explanation.threshold = state_->rule().threshold();
  if (state_->graph_[x].component != state_->graph_[z].component) return explanation;
  const bool is_together = state_->registry_.clusterOf(x) == state_->registry_.clusterOf(z);
  explanation.verdict =
      is_together ? PairExplanation::Verdict::kTogether : PairExplanation::Verdict::kApart;
  Replay replay(*state_, state_->graph_[x].component);
  const std::uint32_t node_a = replay.indexOf(a);
  const std::uint32_t node_b = replay.indexOf(b);
  for (; !replay.isAtEnd(); replay.advance()) {
    if (!is_together && replay.isAtCut()) explanation.stop = replay.explainNext();
    const std::uint32_t root_a = replay.findRoot(node_a);
    const std::uint32_t root_b = replay.findRoot(node_b);
    const auto [low, high] = std::minmax(root_a, root_b);
    if (replay.next().a != low || replay.next().b != high) continue;
    explanation.merge = replay.explainNext();
    break;
  }
  return explanation;
}

PrimitiveExplanation IncrementalClustering::explainPrimitive(NodeKey key) {
  state_->apply();
  const PrimitiveGraph::Primitive& primitive = state_->graph_[state_->graph_.find(key)];
  PrimitiveExplanation explanation;
  explanation.key = key;
  explanation.scores = primitive.scores;
  explanation.alpha = state_->config_.alpha;
  explanation.is_pruned = isPruned(primitive.scores, state_->config_);
  explanation.relevance = primitive.relevance;
  if (primitive.scores.empty()) return explanation;
  const auto best = std::max_element(primitive.scores.begin(), primitive.scores.end());
  explanation.best_task = static_cast<int>(best - primitive.scores.begin()) + 1;
  explanation.best_score = *best;
  return explanation;
}

ClusteringStatistics IncrementalClustering::statistics() {
  state_->apply();
  ClusteringStatistics statistics = state_->times_;
  statistics.num_primitives = state_->graph_.size();
  statistics.num_tasks = static_cast<std::size_t>(state_->scorer_.numTasks());
  statistics.num_components = state_->components_.size();
  statistics.num_clusters = state_->registry_.size();
  for (const Slot slot : state_->allSlots()) {
    if (isPruned(state_->graph_[slot].scores, state_->config_)) ++statistics.num_pruned;
  }
  if (state_->graph_.size() == 0) return statistics;
  const double count = static_cast<double>(state_->graph_.size());
  statistics.information_bits = state_->totalBits() / count;
  statistics.kept_bits = statistics.information_bits;
  for (const Merge& merge : mergeSequence()) {
    statistics.kept_bits -= merge.d;
    statistics.deltas.push_back(merge.delta);
  }
  statistics.compression_bits = computeClusterEntropy(*state_);
  statistics.compression_ratio = count / static_cast<double>(state_->registry_.size());
  return statistics;
}

}  // namespace tsg::bottleneck
