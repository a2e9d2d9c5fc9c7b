// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <vector>

#include "cluster_registry.h"
#include "component_set.h"
#include "information.h"
#include "primitive_graph.h"
#include "task_scene_graph/bottleneck/clustering.h"
#include "task_scene_graph/bottleneck/relevance.h"

namespace tsg::bottleneck {

/// What a clustering holds, and the steps that bring it up to date (clustering_update.cpp).
class ClusteringState {
 public:
  ClusteringState(const ClusteringConfig& config, Adjacency adjacency);

  /// Brings everything below up to date with the changes since the last call.
  void apply();

  const PrimitiveGraph& graph() const { return graph_; }
  const ClusterRegistry& registry() const { return registry_; }
  const ComponentSet& components() const { return components_; }
  double totalBits() const;
  MergeRule rule() const { return MergeRule(config_, totalBits()); }

 private:
  friend class IncrementalClustering;

  void checkDimension(const Embedding& embedding, NodeKey key) const;
  void markScoresPending(Slot slot);
  void updateScores();
  void updateRelevance(const std::vector<Slot>& slots);
  std::vector<Slot> allSlots() const;

  std::vector<Slot> dissolve(const PrimitiveGraph::Touched& touched);
  std::vector<std::vector<Slot>> findComponents(const std::vector<Slot>& loose);
  std::vector<ComponentIndex> storeTapes(std::vector<std::vector<Slot>> parts,
                                         std::vector<MergeTape> tapes);
  AgglomerationProblem makeProblem(const std::vector<Slot>& nodes) const;
  const Component* findFormer(const std::vector<Slot>& nodes) const;
  FormerRun makeFormerRun(const Component& former, const std::vector<Slot>& nodes) const;
  void nameClusters(const std::vector<ComponentIndex>& rerun);
  void compactChanged();
  Cluster makeCluster(std::uint32_t entry, const std::vector<Slot>& members);
  void appendClusters(ComponentIndex index, std::vector<Cluster>& clusters);

  ClusteringConfig config_;
  TaskScorer scorer_;
  PrimitiveGraph graph_;
  InformationSum information_;
  ComponentSet components_;
  ClusterRegistry registry_;

  Eigen::Index dimension_ = 0;  // of the primitives, while there are any
  bool is_relevance_stale_ = false;
  bool is_cut_stale_ = false;
  std::vector<Slot> pending_scores_;
  std::vector<std::uint32_t> former_;              // clusters of dissolved components
  std::map<ComponentIndex, Component> dissolved_;  // until their primitives have new ones
  std::vector<std::uint32_t> local_;    // by slot: position in its component, while running
  std::vector<double> dense_;           // by task: scratch
  ClusteringStatistics times_;          // its times only
  std::vector<std::uint64_t> changed_;  // not yet reported; may repeat, or be gone
  std::size_t changed_limit_ = 1024;    // of its size, before it is compacted
  std::vector<std::uint64_t> removed_;  // not yet reported
};

}  // namespace tsg::bottleneck
