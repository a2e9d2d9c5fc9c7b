// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/scoring.h"

namespace task_scene_graph::scene_graph {

TaskScore findBestTask(const Embedding& embedding, const EmbeddingMatrix& tasks) {
  TaskScore best;
  for (Eigen::Index j = 0; j < tasks.rows(); ++j) {
    const double cosine = computeCosine(embedding, tasks.row(j).transpose());
    if (best.task_index >= 0 && cosine <= best.cosine) continue;
    best = {static_cast<int>(j), cosine};
  }
  return best;
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

}  // namespace task_scene_graph::scene_graph
