// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
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
}

namespace tsg::scene_graph {

/// What a new place graph changed for the clustering, and what was wrong with it.
struct PlaceUpdate {
  std::size_t inserted = 0;  ///< places that now have an embedding and had none before, or are new
  std::size_t updated = 0;   ///< places whose embedding changed
  std::size_t erased = 0;    ///< places that are gone or lost their embedding
  std::size_t edges_inserted = 0;
  std::size_t edges_erased = 0;
  std::size_t without_embedding = 0;  ///< places in no region for want of an embedding
  std::size_t rejected = 0;  ///< places in no region: embedding of another size, not finite
  std::string error;         ///< why the first rejected one was; "" if none was
};

/// The regions: clusters of places along the edges of the place graph. Not thread-safe.
class RegionLayer {
 public:
  explicit RegionLayer(const SceneGraphConfig& config);
  ~RegionLayer();

  /// @throws config::ConfigError as SceneGraphBuilder::setPlaceTasks
  void setTasks(const TaskList& tasks);
  void setConfig(const SceneGraphConfig& config);
  /// @throws std::invalid_argument as SceneGraphBuilder::setPlaces
  PlaceUpdate setPlaces(const PlaceGraphPtr& places);

  /// Clusters what changed. Ascending by id.
  std::vector<Region> computeRegions();
  /// The same as clusters only. O(places).
  std::vector<RegionCluster> computeClusters();

  /// See SceneGraphBuilder.
  std::string explainRegion(RegionId id);
  std::string explainPair(PlaceId a, PlaceId b);

  const PlaceGraphPtr& places() const { return places_; }  ///< never null
  CosineSummary summarizeCosines() const;                  ///< of the places to the tasks
  const TaskList& tasks() const { return tasks_; }

 private:
  using PlaceKeys = std::pair<std::uint64_t, std::uint64_t>;

  std::vector<const Place*> findUsable(const PlaceGraph& graph, PlaceUpdate& update) const;
  PlaceUpdate apply(const PlaceGraphPtr& places);
  void requireClustered(PlaceId id) const;
  void eraseEdges(const std::vector<PlaceKeys>& edges, PlaceUpdate& update);
  void replacePlaces(const std::vector<const Place*>& usable, PlaceUpdate& update);
  void insertEdges(const std::vector<PlaceKeys>& edges, PlaceUpdate& update);

  SceneGraphConfig config_;
  TaskList tasks_;
  bottleneck::TaskScorer scorer_;  ///< of `tasks_`
  std::unique_ptr<bottleneck::IncrementalClustering> clustering_;
  PlaceGraphPtr places_;
  std::vector<const Place*> clustered_;  ///< the places of `places_` that are in `clustering_`
  std::vector<PlaceKeys> edges_;         ///< ... and the edges between them
};

}  // namespace tsg::scene_graph
