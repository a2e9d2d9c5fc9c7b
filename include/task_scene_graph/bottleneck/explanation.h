// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "task_scene_graph/bottleneck/distribution.h"
#include "task_scene_graph/bottleneck/graph_types.h"

namespace tsg::bottleneck {

/// A merge with what it mixed. A cluster is named by its smallest primitive.
struct ExplainedMerge {
  NodeKey a = 0;
  NodeKey b = 0;
  double d = 0.0;         ///< Eq. 2, bits
  double delta = 0.0;     ///< what is compared with the threshold (Eq. 3, or delta_bits)
  SparseMasses before_a;  ///< p(y | a)
  SparseMasses before_b;  ///< p(y | b)
  SparseMasses after;     ///< p(y | a and b)
  int task = 0;           ///< argmax of `after`, 0 = null
};

/// How a cluster came to be.
struct ClusterExplanation {
  std::uint64_t id = 0;
  int task = 0;  ///< the task it serves, 0 = null
  double threshold = 0.0;
  std::vector<ExplainedMerge> merges;  ///< inside the cluster, in the order of the run
  /// The merge that the threshold stopped the cluster's component at; none if nothing was left.
  std::optional<ExplainedMerge> stop;
};

/// Why two primitives are, or are not, in one cluster.
struct PairExplanation {
  enum class Verdict {
    kTogether,      ///< `merge` joined them
    kApart,         ///< `merge` would have joined them, but `stop` was rejected before or is it
    kNotConnected,  ///< no path of allowed merges leads from one to the other
  };
  Verdict verdict = Verdict::kNotConnected;
  double threshold = 0.0;
  std::optional<ExplainedMerge> merge;
  std::optional<ExplainedMerge> stop;  ///< with kApart: the first rejected merge of the component
};

/// What a primitive was found to serve, and whether Eq. 5's pre-pruning sent it to the null task.
struct PrimitiveExplanation {
  NodeKey key = 0;
  std::vector<double> scores;  ///< phi_1..phi_M
  int best_task = 0;           ///< 1-based, smallest if equal; 0 without a task
  double best_score = 0.0;     ///< max phi; 0 without a task
  double alpha = 0.0;          ///< pruned if best_score < alpha
  bool is_pruned = false;
  SparseMasses relevance;  ///< p(y|x)
};

/// Numbers on the present clustering. Times are of the last change that was applied.
struct ClusteringStatistics {
  std::size_t num_primitives = 0;
  std::size_t num_tasks = 0;
  std::size_t num_components = 0;
  std::size_t num_clusters = 0;
  std::size_t num_pruned = 0;      ///< primitives that serve the null task alone
  double information_bits = 0.0;   ///< I(X;Y) with the configured prior
  double kept_bits = 0.0;          ///< I(X~;Y) = I(X;Y) - sum of d
  double compression_bits = 0.0;   ///< I(X;X~) = H(X~), of log2 N without any merge
  double compression_ratio = 1.0;  ///< primitives per cluster
  std::vector<double> deltas;      ///< of the accepted merges in order
  double scoring_s = 0.0;          ///< embeddings to p(y|x)
  double adjacency_s = 0.0;        ///< boxes to edges
  double agglomeration_s = 0.0;    ///< merge tapes
  double naming_s = 0.0;           ///< cuts and stable ids
};

}  // namespace tsg::bottleneck
