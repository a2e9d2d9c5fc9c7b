// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/config/visitor.h"

namespace tsg::bottleneck {

/// p(y) inside the normaliser I(X;Y). The paper leaves it open; merges do not depend on it.
enum class Prior {
  kUniform,  ///< 1 / (M + 1): the published thresholds assume it. I = log2(M + 1) - mean H(p(y|x))
  kMarginal  ///< mean of p(y|x): the mutual information proper
};

/// What the loss of a merge is compared with.
enum class Normaliser {
  /// delta(k) = D / (N I(X;Y)) [Clio24, Eq. 3]: the fraction of all information. Drifts: the same
  /// two primitives are merged more readily in a larger map.
  kPaper,
  /// delta_bits(k) = D / 2: the bits per primitive that a merge of two lone primitives with this
  /// loss would give up, in [0, 1] for them (it is their Jensen-Shannon divergence). Does not move
  /// as the map grows. delta_bits = delta N I(X;Y) / 2, so the paper's 1e-5 at its maps of about
  /// 1500 primitives and 4.3 bits is 0.03. It has to be a function of D alone: only then is a cut
  /// of each component also a cut of the whole graph.
  kSizeInvariant
};

/// Agglomerative information bottleneck [Clio24, Sec. III].
struct ClusteringConfig {
  double alpha = 0.23;
  double delta = 1e-5;
  int top_k = 2;
  bool prune_null = true;
  Prior prior = Prior::kUniform;
  Normaliser normaliser = Normaliser::kPaper;
  double delta_bits = 0.03;
  bool cumulative = true;
  int num_threads = 1;

  /// The threshold that `normaliser` is compared with.
  double threshold() const { return normaliser == Normaliser::kPaper ? delta : delta_bits; }

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("alpha", self.alpha, {0.0, 1.0}, "", "score of the null task");
    v.field("delta", self.delta, {0.0, 1.0}, "",
            "merge while the fraction of I(X;Y) lost is below this (normaliser: paper)");
    v.field("top_k", self.top_k, {1, 1000000}, "", "tasks kept per primitive, null included");
    v.field("prune_null", self.prune_null, {}, "",
            "primitives whose best score is below alpha serve the null task only");
    v.choice("prior", self.prior, {{"uniform", Prior::kUniform}, {"marginal", Prior::kMarginal}},
             "p(y) inside I(X;Y)");
    v.choice("normaliser", self.normaliser,
             {{"paper", Normaliser::kPaper}, {"size_invariant", Normaliser::kSizeInvariant}},
             "what the loss of a merge is compared with");
    v.field("delta_bits", self.delta_bits, {0.0, 1.0}, "bits per primitive",
            "merge while half the bits lost is below this (normaliser: size_invariant)");
    v.field("cumulative", self.cumulative, {}, "",
            "the l-th best task counts k - l + 1 times (Eq. 5); off: once");
    v.field("num_threads", self.num_threads, {1, 256}, "", "threads; results do not depend on it");
  }
};

}  // namespace tsg::bottleneck
