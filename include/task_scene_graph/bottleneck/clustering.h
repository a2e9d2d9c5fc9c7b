// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "task_scene_graph/bottleneck/config.h"
#include "task_scene_graph/bottleneck/distribution.h"
#include "task_scene_graph/bottleneck/explanation.h"
#include "task_scene_graph/bottleneck/graph_types.h"
#include "task_scene_graph/core/box.h"
#include "task_scene_graph/core/embedding.h"

namespace tsg::bottleneck {

class ClusteringState;

/// A task-relevant concept x~: primitives that serve the same task.
struct Cluster {
  std::uint64_t id = 0;          ///< stable: see ClusterRegistry
  std::vector<NodeKey> members;  ///< ascending
  SparseMasses relevance;        ///< p(y | cluster): the mean of its primitives' p(y|x)
  int task = 0;  ///< argmax of p(y | cluster), smallest if equal; 0 null, j task j-1
};

/// One merge of the run over the whole graph. A cluster is named by its smallest primitive.
struct Merge {
  NodeKey a = 0;  ///< a < b; the result is named a
  NodeKey b = 0;
  double d = 0.0;      ///< Eq. 2, bits: D rounded to 9 decimals, over N
  double delta = 0.0;  ///< Eq. 3 (or delta_bits, see Normaliser), loss positive
};

/// What `applyChanges` did.
struct ClusteringUpdate {
  std::vector<Cluster> changed;        ///< new, or with other primitives or relevance; ascending id
  std::vector<std::uint64_t> removed;  ///< ids that are no more, ascending
};

/// Agglomerative information bottleneck that follows a changing map [Clio24, Sec. III, App. A, B].
///
/// At every moment the clusters are those that a batch run over all primitives with the present
/// configuration gives; only components that changes touch are run again, the others are re-cut.
/// Changes are cheap and take effect together at the next question. Not thread-safe.
class IncrementalClustering {
 public:
  using Adjacency = bottleneck::Adjacency;

  /// @throws config::ConfigError if a value is out of range.
  IncrementalClustering(const ClusteringConfig& config, Adjacency adjacency);
  ~IncrementalClustering();
  IncrementalClustering(IncrementalClustering&&) noexcept;
  IncrementalClustering& operator=(IncrementalClustering&&) noexcept;

  /// M x D rows; M may be 0 (then every primitive serves the null task). @throws
  /// std::invalid_argument if a row is zero or not finite (names it), or D is not that of the
  /// primitives (names both); the former tasks then stay in force.
  void setTasks(const EmbeddingMatrix& tasks);

  /// `box` in metres, used with kBoxOverlap only; an empty one overlaps nothing. @throws
  /// std::invalid_argument, naming the key, if it is taken, or the embedding is zero, not finite or
  /// of another dimension than tasks and primitives (names both), or the box is not finite. Nothing
  /// has changed then.
  void insert(NodeKey key, const Embedding& embedding, const Aabb& box = {});
  /// Replaces embedding and box. @throws as insert, and if the key is not there.
  void update(NodeKey key, const Embedding& embedding, const Aabb& box = {});
  /// The same with an embedding that is shared instead of copied: not null, and never changes.
  void insert(NodeKey key, std::shared_ptr<const Embedding> embedding, const Aabb& box = {});
  void update(NodeKey key, std::shared_ptr<const Embedding> embedding, const Aabb& box = {});
  /// @throws std::invalid_argument if the key is not there.
  void erase(NodeKey key);
  bool contains(NodeKey key) const;
  std::size_t size() const;

  /// kGiven only. False if the edge is there already. @throws std::invalid_argument if a == b or
  /// one is not there; std::logic_error with kBoxOverlap.
  bool insertEdge(NodeKey a, NodeKey b);
  /// kGiven only. False if there is no such edge. @throws as insertEdge.
  bool eraseEdge(NodeKey a, NodeKey b);

  const ClusteringConfig& config() const;
  /// @throws config::ConfigError if a value is out of range; the former stays in force.
  void setConfig(const ClusteringConfig& config);
  void setAlpha(double alpha);
  /// The threshold of the normaliser in force: `delta` or `delta_bits`. Only re-cuts.
  void setDelta(double delta);
  void setTopK(int top_k);

  /// Gives clusters the ids that they had in a map of before: where the same primitives are
  /// together they keep theirs, else as after any change. Before the first cluster is asked for.
  /// @param clusters  ids ascending from 1 with their primitives; keys that are not there do not
  /// count
  /// @throws std::logic_error if there are clusters already; std::invalid_argument naming an id out
  /// of order.
  void adoptIds(const std::vector<std::pair<std::uint64_t, std::vector<NodeKey>>>& clusters);

  /// Applies pending changes and returns what they changed since the last call. O(touched
  /// components x log), whatever the size of the map.
  ClusteringUpdate applyChanges();
  /// All clusters, ascending by id; applies pending changes. O(N).
  std::vector<Cluster> clusters();
  /// Stable id of the cluster that holds a primitive. @throws std::invalid_argument if the key is
  /// not there.
  std::uint64_t clusterOf(NodeKey key);

  /// phi_1..phi_M of a primitive. @throws as clusterOf.
  std::vector<double> scores(NodeKey key);
  /// p(y|x) of a primitive. @throws as clusterOf.
  SparseMasses relevance(NodeKey key);
  /// The sum of p(y|x) over those of the keys that are there, and how many these are. O(keys).
  std::pair<SparseMasses, std::size_t> sumRelevance(const std::vector<NodeKey>& keys);
  /// I(X;Y) in bits, the normaliser of Eq. 3 for the configured prior; 0 for no primitive.
  double information();
  /// The accepted merges in the order of the batch run. O(N log components).
  std::vector<Merge> mergeSequence();

  /// @throws std::out_of_range if there is no such cluster. O(component).
  ClusterExplanation explainCluster(std::uint64_t id);
  /// @throws std::invalid_argument if a key is not there. O(component).
  PairExplanation explainPair(NodeKey a, NodeKey b);
  /// @throws std::invalid_argument if the key is not there.
  PrimitiveExplanation explainPrimitive(NodeKey key);
  /// O(N log components).
  ClusteringStatistics statistics();

 private:
  std::unique_ptr<ClusteringState> state_;
};

}  // namespace tsg::bottleneck
