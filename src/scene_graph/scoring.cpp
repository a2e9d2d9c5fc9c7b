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

bool hasDirection(const Embedding& embedding) {
  return embedding.allFinite() && (embedding.array() != 0.0F).any();
}

void EmbeddingMean::add(const Embedding& embedding) {
  if (count_ == 0) sum_ = Eigen::VectorXd::Zero(embedding.size());
  sum_ += embedding.cast<double>();
  ++count_;
}

Embedding EmbeddingMean::mean() const {
  return count_ == 0 ? Embedding() : Embedding((sum_ / count_).cast<float>());
}

}  // namespace tsg::scene_graph
