// SPDX-License-Identifier: BSD-3-Clause
// How changes take effect.
#include <algorithm>
#include <chrono>
#include <utility>

#include "clustering_state.h"
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

ClusteringState::ClusteringState(const ClusteringConfig& config, Adjacency adjacency)
    : config_(config), graph_(adjacency) {
  config::validate(config, "clustering");
}

double ClusteringState::totalBits() const {
  return information_.computeTotalBits(config_.prior, scorer_.numTasks());
}

void ClusteringState::apply() {
  ClusteringStatistics times;
  Stopwatch watch;
  updateScores();  // [Clio24, Eq. 4, 5]
  times.scoring_s = watch.lap();
  graph_.updateAdjacency();  // Sec. IV-B
  times.adjacency_s = watch.lap();
  std::vector<std::vector<Slot>> parts = findComponents(dissolve(graph_.takeTouched()));  // App. B
  std::vector<MergeTape> tapes(parts.size());
  parallelFor(parts.size(), config_.num_threads, [&](std::size_t i) {
    const AgglomerationProblem problem = makeProblem(parts[i]);
    const Component* former = areAlike(problem) ? nullptr : findFormer(parts[i]);
    tapes[i] = former != nullptr ? reagglomerate(problem, makeFormerRun(*former, parts[i]))
                                 : agglomerate(problem);  // Algorithm 1, Eq. 2
  });
  const std::vector<ComponentIndex> rerun = storeTapes(std::move(parts), std::move(tapes));
  times.agglomeration_s = watch.lap();
  if (rerun.empty() && former_.empty() && !is_cut_stale_) return;
  nameClusters(rerun);  // Eq. 3
  times.naming_s = watch.lap();
  times_ = times;
  is_cut_stale_ = false;
}

void ClusteringState::markScoresPending(Slot slot) {
  if (graph_[slot].is_score_pending) return;
  graph_[slot].is_score_pending = true;
  pending_scores_.push_back(slot);
}

std::vector<Slot> ClusteringState::allSlots() const {
  std::vector<Slot> slots;
  slots.reserve(graph_.size());
  for (Slot slot = 0; slot < graph_.tableSize(); ++slot) {
    if (graph_[slot].is_alive) slots.push_back(slot);
  }
  return slots;
}

void ClusteringState::updateScores() {
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
    for (std::size_t i = begin; i < end; ++i)
      embeddings.push_back(graph_[slots[i]].embedding.get());
    std::vector<std::vector<double>> scores = scorer_.computeScores(embeddings);  // phi
    for (std::size_t i = begin; i < end; ++i) {
      graph_[slots[i]].scores = std::move(scores[i - begin]);
    }
  });
  updateRelevance(std::exchange(is_relevance_stale_, false) ? allSlots() : slots);
}

void ClusteringState::updateRelevance(const std::vector<Slot>& slots) {
  for (const Slot slot : slots) {
    SparseMasses relevance = computeRelevance(graph_[slot].scores, config_);  // Eq. 5
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

void ClusteringState::nameClusters(const std::vector<ComponentIndex>& rerun) {
  std::vector<ComponentIndex> changed = components_.recut(rule().limit());  // Eq. 3
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

void ClusteringState::compactChanged() {
  std::sort(changed_.begin(), changed_.end());
  changed_.erase(std::unique(changed_.begin(), changed_.end()), changed_.end());
  const auto is_gone = [this](std::uint64_t id) { return !registry_.contains(id); };
  changed_.erase(std::remove_if(changed_.begin(), changed_.end(), is_gone), changed_.end());
  changed_limit_ = 2 * changed_.size() + 1024;
}

}  // namespace tsg::bottleneck
