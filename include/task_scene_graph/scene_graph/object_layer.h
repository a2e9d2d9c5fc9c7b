// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "task_scene_graph/bottleneck/relevance.h"
#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/scene_graph/clusters.h"
#include "task_scene_graph/scene_graph/config.h"
#include "task_scene_graph/scene_graph/scene_graph.h"
#include "task_scene_graph/scene_graph/scoring.h"
#include "task_scene_graph/scene_graph/tasks.h"

namespace tsg::bottleneck {
class IncrementalClustering;
struct Cluster;
}  // namespace tsg::bottleneck

namespace tsg::scene_graph {

/// How many primitives were given, and what became of them.
struct PrimitiveCounters {
  std::size_t clustered = 0;          ///< added, with an embedding
  std::size_t without_embedding = 0;  ///< added as pure geometry: in the graph, in no object
  std::size_t repeated = 0;           ///< dropped: a primitive of that id is here already
  std::size_t replaced = 0;           ///< added in the place of the one of that id
  std::size_t rejected = 0;  ///< dropped: embedding of another size or not finite, or no box

  PrimitiveCounters& operator+=(const PrimitiveCounters& other);
};

/// What is done with a primitive whose id is that of a finished one; in the place of a provisional
/// one it is put in any case.
enum class Repeated { kDrop, kReplace };

struct PrimitiveUpdate {
  PrimitiveCounters counters;  ///< of this call
  std::string error;           ///< why the first rejected one was; "" if none was
};

/// The objects: clusters of object primitives whose boxes overlap. Not thread-safe.
class ObjectLayer {
 public:
  explicit ObjectLayer(const SceneGraphConfig& config);
  ~ObjectLayer();

  /// @throws config::ConfigError as SceneGraphBuilder::setObjectTasks
  void setTasks(const TaskList& tasks);
  void setConfig(const SceneGraphConfig& config);
  PrimitiveUpdate add(const std::vector<ObjectPrimitivePtr>& primitives,
                      Repeated repeated = Repeated::kDrop);

  /// Takes primitives out; unknown ids are passed over. Returns how many were here. O(primitives).
  std::size_t erase(const std::vector<PrimitiveId>& ids);

  /// Objects keep the ids that they had in a map of before, as IncrementalClustering::adoptIds().
  void adoptIds(const std::vector<ObjectCluster>& clusters);

  /// The published objects of now, see isPublished(); ascending by id, without places. Only
  /// clusters that changed are described anew. O(changed clusters * D + objects * D).
  std::vector<SceneObject> computeObjects();
  /// All clusters of now, ascending by id. O(primitives).
  std::vector<ObjectCluster> computeClusters();

  /// See SceneGraphBuilder.
  std::string explainObject(ObjectId id);
  std::string explainPrimitive(PrimitiveId id);
  std::string explainPair(PrimitiveId a, PrimitiveId b);

  std::vector<ObjectPrimitivePtr> primitives() const;  ///< ascending by id
  CosineSummary summarizeCosines() const;              ///< of the primitives to the tasks
  const TaskList& tasks() const { return tasks_; }
  const PrimitiveCounters& counters() const { return counters_; }
  Stamp newest() const { return newest_; }  ///< latest last_seen of all primitives

 private:
  void addOne(const ObjectPrimitivePtr& primitive, Repeated repeated, PrimitiveUpdate& update);
  void cluster(const ObjectPrimitive& primitive);
  std::string findFault(const ObjectPrimitive& primitive) const;
  void requireClustered(PrimitiveId id) const;
  void updateObject(const bottleneck::Cluster& cluster);
  std::vector<const ObjectPrimitive*> findMembers(const std::vector<std::uint64_t>& keys) const;

  SceneGraphConfig config_;
  TaskList tasks_;
  bottleneck::TaskScorer scorer_;  ///< of `tasks_`
  std::unique_ptr<bottleneck::IncrementalClustering> clustering_;
  std::map<std::uint64_t, ObjectPrimitivePtr> primitives_;
  std::map<std::uint64_t, SceneObject> objects_;  ///< the published ones, by the clusters' ids
  bool are_scores_stale_ = false;                 ///< tasks or publishedFrom() have changed
  Eigen::Index embedding_size_ = 0;  ///< of the clustered primitives; 0 = there is none yet
  PrimitiveCounters counters_;
  Stamp newest_;
};

}  // namespace tsg::scene_graph
