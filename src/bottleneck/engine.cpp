// SPDX-License-Identifier: BSD-3-Clause
#include "engine.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/core/parallel.h"

namespace tsg::bottleneck {
namespace {

class Stopwatch {
 public:
  /// Seconds since the last lap.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(last_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace

ClusteringEngine::ClusteringEngine(const ClusteringConfig& config, Adjacency adjacency)
    : config_(config), graph_(adjacency) {
  config::validate(config, "clustering");
}

void ClusteringEngine::setTasks(const EmbeddingMatrix& tasks) {
  TaskScorer scorer(tasks);
  if (graph_.size() > 0 && scorer.numTasks() > 0 && scorer.dimension() != dimension_) {
    throw std::invalid_argument("the task embeddings have dimension " +
                                std::to_string(scorer.dimension()) + ", those of the primitives " +
                                std::to_string(dimension_) + "; expected the same");
  }
  scorer_ = std::move(scorer);
  for (const Slot slot : allSlots()) markScoresPending(slot);
  is_cut_stale_ = true;
}

void ClusteringEngine::setConfig(const ClusteringConfig& config) {
  config::validate(config, "clustering");
  is_relevance_stale_ |= config.alpha != config_.alpha || config.top_k != config_.top_k ||
                         config.prune_null != config_.prune_null ||
                         config.cumulative != config_.cumulative;
  is_cut_stale_ = true;
  config_ = config;
}

void ClusteringEngine::checkDimension(const Embedding& embedding, NodeKey key) const {
  checkEmbedding(embedding, describeKey(key));
  const Eigen::Index expected = scorer_.numTasks() > 0 ? scorer_.dimension()
                                : graph_.size() > 0    ? dimension_
                                                       : embedding.size();
  if (embedding.size() == expected) return;
  throw std::invalid_argument("the embedding of " + describeKey(key) + " has dimension " +
                              std::to_string(embedding.size()) + "; expected " +
                              std::to_string(expected) +
                              (scorer_.numTasks() > 0 ? " as the tasks" : " as the others"));
}

void ClusteringEngine::insert(NodeKey key, const Embedding& embedding, const Aabb& box) {
  checkDimension(embedding, key);
  markScoresPending(graph_.insert(key, embedding, box));
  dimension_ = embedding.size();
  is_cut_stale_ = true;
}

void ClusteringEngine::update(NodeKey key, const Embedding& embedding, const Aabb& box) {
  const Slot slot = graph_.find(key);
  checkDimension(embedding, key);
  if (graph_.update(slot, embedding, box)) markScoresPending(slot);
}

void ClusteringEngine::erase(NodeKey key) {
  const Slot slot = graph_.find(key);
  if (!graph_[slot].relevance.empty()) information_.remove(graph_[slot].relevance);
  graph_.erase(slot);
  registry_.forget(slot);
  is_cut_stale_ = true;
}

bool ClusteringEngine::insertEdge(NodeKey a, NodeKey b) {
  if (graph_.adjacency() == Adjacency::kGiven) {
    return graph_.insertEdge(graph_.find(a), graph_.find(b));
  }
  throw std::logic_error("edges follow from the boxes here; expected Adjacency::kGiven");
}

bool ClusteringEngine::eraseEdge(NodeKey a, NodeKey b) {
  if (graph_.adjacency() == Adjacency::kGiven) {
    return graph_.eraseEdge(graph_.find(a), graph_.find(b));
  }
  throw std::logic_error("edges follow from the boxes here; expected Adjacency::kGiven");
}

void ClusteringEngine::markScoresPending(Slot slot) {
  if (graph_[slot].is_score_pending) return;
  graph_[slot].is_score_pending = true;
  pending_scores_.push_back(slot);
}

std::vector<Slot> ClusteringEngine::allSlots() const {
  std::vector<Slot> slots;
  slots.reserve(graph_.size());
  for (Slot slot = 0; slot < graph_.tableSize(); ++slot) {
    if (graph_[slot].is_alive) slots.push_back(slot);
  }
  return slots;
}

double ClusteringEngine::totalBits() const {
  return information_.computeTotalBits(config_.prior, scorer_.numTasks());
}

void ClusteringEngine::apply() {
  ClusteringStatistics times;
  Stopwatch watch;
  updateScores();
  times.scoring_s = watch.lap();
  graph_.updateAdjacency();
  times.adjacency_s = watch.lap();
  const std::vector<Slot> loose = dissolve(graph_.takeTouched());
  const std::vector<ComponentIndex> rerun = rebuild(findComponents(loose));
  times.agglomeration_s = watch.lap();
  if (rerun.empty() && former_.empty() && !is_cut_stale_) return;
  nameClusters(rerun);
  times.naming_s = watch.lap();
  times_ = times;
  is_cut_stale_ = false;
}

void ClusteringEngine::updateScores() {
  std::vector<Slot> slots;
  for (const Slot slot : pending_scores_) {
    if (std::exchange(graph_[slot].is_score_pending, false)) slots.push_back(slot);
  }
  pending_scores_.clear();
  constexpr std::size_t kBlock = 32;
  parallelFor((slots.size() + kBlock - 1) / kBlock, config_.num_threads, [&](std::size_t block) {
    const std::size_t begin = block * kBlock;
    const std::size_t end = std::min(begin + kBlock, slots.size());
    std::vector<const Embedding*> embeddings;
    for (std::size_t i = begin; i < end; ++i) embeddings.push_back(&graph_[slots[i]].embedding);
    std::vector<std::vector<double>> scores = scorer_.computeScores(embeddings);
    for (std::size_t i = begin; i < end; ++i) {
      graph_[slots[i]].scores = std::move(scores[i - begin]);
    }
  });
  updateRelevance(std::exchange(is_relevance_stale_, false) ? allSlots() : slots);
}

void ClusteringEngine::updateRelevance(const std::vector<Slot>& slots) {
  for (const Slot slot : slots) {
    SparseMasses relevance = computeRelevance(graph_[slot].scores, config_);
    SparseMasses& former = graph_[slot].relevance;
    if (relevance == former) continue;
    if (!former.empty()) information_.remove(former);
    information_.add(relevance);
    former = std::move(relevance);
    graph_[slot].is_changed = true;
    graph_.markTouched(slot);
    is_cut_stale_ = true;
  }
}

void ClusteringEngine::nameClusters(const std::vector<ComponentIndex>& rerun) {
  std::vector<ComponentIndex> changed = components_.recut(rule().limit());
  for (const ComponentIndex index : changed) {
    const auto& clusters = components_[index].clusters;
    former_.insert(former_.end(), clusters.begin(), clusters.end());
  }
  changed.insert(changed.end(), rerun.begin(), rerun.end());
  std::sort(changed.begin(), changed.end());
  changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
  std::vector<bool> is_rerun;
  for (const ComponentIndex index : changed)
    is_rerun.push_back(components_[index].clusters.empty());
  const auto names =
      registry_.assign(changed, is_rerun, std::exchange(former_, {}), graph_, components_);
  changed_.insert(changed_.end(), names.changed.begin(), names.changed.end());
  removed_.insert(removed_.end(), names.removed.begin(), names.removed.end());
  if (changed_.size() > changed_limit_) compactChanged();
}

void ClusteringEngine::compactChanged() {
  std::sort(changed_.begin(), changed_.end());
  changed_.erase(std::unique(changed_.begin(), changed_.end()), changed_.end());
  const auto is_gone = [this](std::uint64_t id) { return !registry_.contains(id); };
  changed_.erase(std::remove_if(changed_.begin(), changed_.end(), is_gone), changed_.end());
  changed_limit_ = 2 * changed_.size() + 1024;
}

}  // namespace tsg::bottleneck
