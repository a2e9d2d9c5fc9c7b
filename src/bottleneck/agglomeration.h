// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "task_scene_graph/bottleneck/distribution.h"

namespace tsg::bottleneck {

/// One merge of clusters a < b, named by their smallest primitive; the result is named a.
struct MergeStep {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  std::int64_t cost = 0;  ///< D in kCostUnit

  friend bool operator==(const MergeStep& l, const MergeStep& r) {
    return l.a == r.a && l.b == r.b && l.cost == r.cost;
  }
};

/// The merges of a graph until nothing is left to merge, in order. Costs need not ascend: a cut is
/// at the first entry whose cost is too large.
using MergeTape = std::vector<MergeStep>;

/// Primitives 0..N-1 (in order of their ids) with p(y|x), and the merges allowed between them.
struct AgglomerationProblem {
  std::vector<const SparseMasses*> relevance;                  ///< N
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;  ///< each once, a != b
  std::size_t hub_degree = 64;  ///< of more neighbours, edges are priced only when they may be best
};

/// Runs Agglomerative IB [Clio24, Algorithm 1] to the end: always the adjacent pair with the
/// smallest (D, smaller id, larger id) is merged.
///
/// A heap of priced edges with lazy deletion, neighbour lists over union-find. A merge prices the
/// edges of the result anew, so that a cluster with many neighbours (the irrelevant background soon
/// touches everything) would make it quadratic; the edges of such hubs wait under lower bounds of
/// their costs instead, and only those of the smaller side are priced (small to large). About
/// O(E log E) times the support on maps; memory O(N support + E). The result does not depend on
/// `hub_degree`. Where areAlike(), O((N + E) log N).
MergeTape agglomerate(const AgglomerationProblem& problem);

/// Whether all primitives have the same p(y|x), as the places of one room do that count for one
/// task: no merge costs anything then, and a former run would not help. O(N support).
bool areAlike(const AgglomerationProblem& problem);

/// An earlier run over much the same graph.
struct FormerRun {
  static constexpr std::uint32_t kGone = ~std::uint32_t{0};

  MergeTape tape;                       ///< to the end, of the former primitives' indices
  std::vector<std::uint32_t> index_of;  ///< former index -> present one, ascending; or kGone
  std::vector<bool> is_changed;         ///< N: primitives that are new, or of other relevance
};

/// The same tape as agglomerate(problem), following the former run where it still holds. Of each
/// edge that one run has and the other has not, at least one end must be changed (or gone).
///
/// As long as two clusters hold the same, unchanged primitives in both runs, so do their costs: the
/// former tape says in which order such pairs are merged, and nothing of them is priced. Only
/// clusters that have no counterpart at that moment are priced: those of changed primitives, and
/// those that what has changed makes merge sooner or later than before, until both runs agree on
/// them again.
MergeTape reagglomerate(const AgglomerationProblem& problem, const FormerRun& former);

}  // namespace tsg::bottleneck
