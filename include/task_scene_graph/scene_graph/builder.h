// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/scene_graph/config.h"
#include "task_scene_graph/scene_graph/object_layer.h"
#include "task_scene_graph/scene_graph/region_layer.h"
#include "task_scene_graph/scene_graph/scene_graph.h"
#include "task_scene_graph/scene_graph/scoring.h"
#include "task_scene_graph/scene_graph/tasks.h"

namespace tsg::scene_graph {

/// Clio's back end [Clio24, Sec. IV-B]: gathers object primitives and places and clusters them into
/// objects and regions for the tasks at hand. Changes are gathered cheaply; the clustering runs in
/// `snapshot()`, and only over what changed. Not thread-safe: one worker owns it.
///
/// Tasks, alpha, delta may be changed at any time: everything is clustered again from the stored
/// embeddings; a change of delta alone only cuts the merge tapes elsewhere.
class SceneGraphBuilder {
 public:
  /// @param world_frame  name of the frame that all coordinates are in
  /// @throws config::ConfigError naming every parameter out of range.
  explicit SceneGraphBuilder(const SceneGraphConfig& config, std::string world_frame = "world");

  /// Replaces the tasks that objects are built for. An empty list is allowed: no objects.
  /// @throws config::ConfigError if the list is not valid or has names without embeddings, or if
  /// the embeddings' size is not that of the primitives already here; the old tasks stay in force.
  void setObjectTasks(const TaskList& tasks);

  /// Replaces the tasks that regions are built for (the caller gives the object tasks where there
  /// is no list of its own). @throws as setObjectTasks.
  void setPlaceTasks(const TaskList& tasks);

  /// Takes effect with the next snapshot. @throws config::ConfigError; the old one stays in force
  /// then.
  void setConfig(const SceneGraphConfig& config);
  const SceneGraphConfig& config() const { return config_; }

  /// Adds primitives; one takes the place of a provisional one of its id. Bad ones are dropped,
  /// counted, and the first of them is explained in the result's `error`.
  /// @param repeated  kReplace: a primitive takes the place of the one of its id, if there is one;
  /// its cluster keeps its id where it keeps its members
  PrimitiveUpdate addPrimitives(const std::vector<ObjectPrimitivePtr>& primitives,
                                Repeated repeated = Repeated::kDrop);

  /// Takes primitives out; unknown ids are passed over. Returns how many were here. O(primitives).
  std::size_t erasePrimitives(const std::vector<PrimitiveId>& ids);

  /// Forgets all primitives and places; tasks and configuration stay, ids of objects and regions
  /// start anew.
  void reset();

  /// Replaces the place graph; only what differs from the one before is touched.
  /// @throws std::invalid_argument if `places` is null or is not as PlaceGraph says (order of ids,
  /// edges between places that exist); the old graph stays in force then.
  PlaceUpdate setPlaces(const PlaceGraphPtr& places);

  /// Objects and regions keep the ids that they had in a map of before, where the same primitives
  /// and places are together. After reset() and what the map holds, before a snapshot.
  /// @throws as IncrementalClustering::adoptIds().
  void adoptIds(const std::vector<ObjectCluster>& objects,
                const std::vector<RegionCluster>& regions);

  /// The graph of everything given so far; the same pointer as before if nothing has changed.
  /// The objects cost what changed plus O(objects * D) and the search of PointIndex, the regions
  /// O(places * D * place tasks), if anything has changed.
  SceneGraphPtr snapshot();

  /// What was given, and how it is clustered now: of this the snapshot is made, see map::makeMap().
  const std::string& worldFrame() const { return world_frame_; }
  const TaskList& objectTasks() const { return objects_->tasks(); }
  const TaskList& placeTasks() const { return regions_->tasks(); }
  std::vector<ObjectPrimitivePtr> primitives() const { return objects_->primitives(); }
  const PlaceGraphPtr& places() const { return regions_->places(); }
  std::vector<ObjectCluster> computeObjectClusters() { return objects_->computeClusters(); }
  std::vector<RegionCluster> computeRegionClusters() { return regions_->computeClusters(); }

  /// Best cosines of all primitives to the object tasks, of all places to the place tasks. Not
  /// cached: O(primitives * tasks * D), 30 ms for 1500 primitives, 50 tasks and D = 768.
  CosineSummary summarizeObjectCosines() const { return objects_->summarizeCosines(); }
  CosineSummary summarizePlaceCosines() const { return regions_->summarizeCosines(); }

  /// Why things are clustered as they are, in words. O(component).
  /// @throws std::invalid_argument naming what is not there, or not clustered for want of an
  /// embedding.
  std::string explainObject(ObjectId id) { return objects_->explainObject(id); }
  std::string explainPrimitive(PrimitiveId id) { return objects_->explainPrimitive(id); }
  std::string explainPrimitives(PrimitiveId a, PrimitiveId b) {
    return objects_->explainPair(a, b);
  }
  std::string explainRegion(RegionId id) { return regions_->explainRegion(id); }
  std::string explainPlaces(PlaceId a, PlaceId b) { return regions_->explainPair(a, b); }

  /// Sums over the whole life of the builder.
  const PrimitiveCounters& primitiveCounters() const { return objects_->counters(); }

 private:
  SceneGraphConfig config_;
  std::string world_frame_;
  std::unique_ptr<ObjectLayer> objects_;
  std::unique_ptr<RegionLayer> regions_;
  SceneGraphPtr snapshot_;  ///< null: something has changed since it was made
};

}  // namespace tsg::scene_graph
