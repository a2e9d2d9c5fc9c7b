// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/scoring.h"

#include <algorithm>
#include <vector>

namespace tsg::scene_graph {

TaskScore findBestTask(const Embedding& embedding, const bottleneck::TaskScorer& tasks) {
  if (tasks.numTasks() == 0 || !hasDirection(embedding)) return {};
  const std::vector<double> cosines = tasks.computeScores(embedding);
  const auto best = std::max_element(cosines.begin(), cosines.end());
  return {static_cast<int>(best - cosines.begin()), *best};
}

CosineSummary summarizeCosines(const std::vector<const Embedding*>& embeddings,
                               const bottleneck::TaskScorer& tasks) {
  CosineSummary summary;
  std::vector<double> best;
  for (const Embedding* embedding : embeddings) {
    if (embedding->size() != tasks.dimension()) continue;
    const TaskScore score = findBestTask(*embedding, tasks);
    if (score.task_index < 0) continue;
    if (best.empty() || score.cosine > summary.highest) {
      summary.highest = score.cosine;
      summary.task_index = score.task_index;
    }
    best.push_back(score.cosine);
  }
  summary.count = best.size();
  if (best.empty()) return summary;
  std::sort(best.begin(), best.end());
  summary.lowest = best.front();
  summary.median = best[best.size() / 2];
  return summary;
}

void EmbeddingMean::add(const Embedding& embedding) {
  if (count_ == 0) sum_ = Eigen::VectorXd::Zero(embedding.size());
  sum_ += embedding.cast<double>();
  ++count_;
}

void EmbeddingMean::add(const EmbeddingMean& other) {
  if (other.count_ == 0) return;
  if (count_ == 0) sum_ = Eigen::VectorXd::Zero(other.sum_.size());
  sum_ += other.sum_;
  count_ += other.count_;
}

Embedding EmbeddingMean::mean() const {
  return count_ == 0 ? Embedding() : Embedding((sum_ / count_).cast<float>());
}

}  // namespace tsg::scene_graph
