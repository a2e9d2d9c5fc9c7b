// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "task_scene_graph/core/embedding.h"

namespace task_scene_graph::scene_graph {

struct TaskScore {
  int task_index = -1;  ///< row of the task matrix; -1 = there are no tasks
  double cosine = 0.0;  ///< in [-1, 1]
};

/// The task with the highest cosine to `embedding` (size D); the first of equal ones.
/// @param tasks  m x D. O(m * D).
TaskScore findBestTask(const Embedding& embedding, const EmbeddingMatrix& tasks);

/// True if every value is finite and at least one is not 0.
bool hasDirection(const Embedding& embedding);

/// Arithmetic mean of embeddings of one size D, summed in double precision in the order given.
class EmbeddingMean {
 public:
  void add(const Embedding& embedding);
  /// Empty if nothing was added.
  Embedding mean() const;

 private:
  Eigen::VectorXd sum_;
  int count_ = 0;
};

}  // namespace task_scene_graph::scene_graph
