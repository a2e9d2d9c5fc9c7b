// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "task_scene_graph/bottleneck/relevance.h"
#include "task_scene_graph/core/embedding.h"

namespace tsg::scene_graph {

struct TaskScore {
  int task_index = -1;  ///< row of the task matrix; -1 = none
  double cosine = 0.0;  ///< in [-1, 1]
};

/// The task with the highest cosine to `embedding` (size D); the first of equal ones; none for an
/// embedding of zeros. The same cosines, to the bit, as those that the clustering compares with
/// alpha. O(m * D).
TaskScore findBestTask(const Embedding& embedding, const bottleneck::TaskScorer& tasks);

/// How the best cosines of many things to a list of tasks are spread.
struct CosineSummary {
  std::size_t count = 0;  ///< things with an embedding
  double highest = 0.0;   ///< best cosine of the one that serves a task best
  int task_index = -1;    ///< of the highest
  double median = 0.0;    ///< of the best cosines
  double lowest = 0.0;    ///< best cosine of the one that serves the tasks least
};

/// Summarises findBestTask over the embeddings that have a direction and the tasks' size. O(n m D).
CosineSummary summarizeCosines(const std::vector<const Embedding*>& embeddings,
                               const bottleneck::TaskScorer& tasks);

/// Arithmetic mean of embeddings of one size D, summed in double precision in the order given.
class EmbeddingMean {
 public:
  void add(const Embedding& embedding);
  /// Adds the sum of another mean of embeddings of the same size.
  void add(const EmbeddingMean& other);
  /// Empty if nothing was added.
  Embedding mean() const;

 private:
  Eigen::VectorXd sum_;
  int count_ = 0;
};

}  // namespace tsg::scene_graph
