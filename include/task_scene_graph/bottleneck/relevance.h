// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "task_scene_graph/bottleneck/config.h"
#include "task_scene_graph/bottleneck/distribution.h"
#include "task_scene_graph/core/embedding.h"

namespace tsg::bottleneck {

/// @throws std::invalid_argument saying whose embedding it is unless it has entries, all finite,
/// and not all zero.
void checkEmbedding(const Eigen::Ref<const Embedding>& embedding, const std::string& whose);

/// Task embeddings, prepared for scoring primitives. Immutable; safe to share between threads.
class TaskScorer {
 public:
  TaskScorer() = default;
  /// `tasks`: M x D rows. @throws std::invalid_argument naming the task whose embedding is zero or
  /// not finite.
  explicit TaskScorer(const EmbeddingMatrix& tasks);

  int numTasks() const { return num_tasks_; }
  /// D, or 0 without a task.
  int dimension() const { return dimension_; }

  /// phi: cosine to each task, in [-1, 1], in double precision. A score depends on the two vectors
  /// alone, bit for bit: not on the other tasks, the other primitives or the thread. O(M D).
  std::vector<double> computeScores(const Embedding& embedding) const;
  /// The same of several, faster: what is read of the tasks is read once for all of them.
  std::vector<std::vector<double>> computeScores(
      const std::vector<const Embedding*>& embeddings) const;

 private:
  int num_tasks_ = 0;
  int dimension_ = 0;
  std::vector<double> tiles_;  // unit rows, by kTileWidth tasks: tile, dimension, task
};

/// p(y|x) of one primitive [Clio24, Eq. 4, 5] from its scores phi_1..phi_M.
///
/// theta = [alpha, max(phi, 0)]; a primitive with max phi < alpha serves the null task alone
/// (`prune_null`); otherwise the l-th largest theta counts k - l + 1 times for l = 1..k and the
/// rest is 0. Equal scores: the smaller index is the larger. k is at most M + 1. If nothing is left
/// to normalise (all theta 0) the primitive serves the null task. deviation: negative cosines count
/// as 0, for p(y|x) must be a probability. O(M log k).
SparseMasses computeRelevance(const std::vector<double>& scores, const ClusteringConfig& config);

/// Whether Eq. 5's pre-pruning applies: max phi < alpha, or there is no task.
bool isPruned(const std::vector<double>& scores, const ClusteringConfig& config);

}  // namespace tsg::bottleneck
