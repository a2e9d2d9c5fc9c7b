// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <unordered_set>
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

class PlaceFeatures;
class RegionIds;

/// What a new place graph changed for the clustering, and what was wrong with it.
struct PlaceUpdate {
  std::size_t inserted = 0;  ///< places that now have a feature and had none before, or are new
  std::size_t updated = 0;   ///< places whose feature was computed anew
  std::size_t erased = 0;    ///< places that are gone or lost their feature
  std::size_t edges_inserted = 0;  ///< edges that the clustering may merge along
  std::size_t edges_erased = 0;
  std::size_t without_embedding = 0;  ///< places in no region for want of a feature
  std::size_t rejected = 0;  ///< places in no region: embedding of another size, not finite
  std::string error;         ///< why the first rejected one was; "" if none was
};

/// @throws std::invalid_argument naming what is wrong: ids that do not ascend from 1, positions or
/// clearances that are not finite, edges not between two places (a < b) or there twice.
void checkPlaceGraph(const PlaceGraph& graph);

/// The regions: clusters of places along the edges of the place graph, or rooms by the shape of
/// free space alone (SceneGraphConfig::region_method). Not thread-safe.
///
/// deviation: the paper clusters the mean embeddings of places with the best two tasks of each.
/// Here the features are smoothed along the edges first (place_smoothing_per_m), a place counts for
/// its best task alone (place_top_k), the threshold does not depend on the size of the map
/// (place_normaliser), and regions of a place or two join a neighbour (min_region_places).
/// docs/places.md has what each is worth; the preset `paper` has none of them.
class RegionLayer {
 public:
  explicit RegionLayer(const SceneGraphConfig& config);
  ~RegionLayer();

  /// @throws config::ConfigError as SceneGraphBuilder::setPlaceTasks
  void setTasks(const TaskList& tasks);
  void setConfig(const SceneGraphConfig& config);
  /// @throws std::invalid_argument as SceneGraphBuilder::setPlaces
  PlaceUpdate setPlaces(const PlaceGraphPtr& places);

  /// Regions keep the ids that they had in a map of before, as RegionIds does.
  void adoptIds(const std::vector<RegionCluster>& clusters);

  /// Clusters what changed and describes it anew; doors and objects are left to connectRegions().
  /// Ascending by id.
  std::vector<Region> computeRegions();
  /// The same as clusters only. O(places).
  std::vector<RegionCluster> computeClusters();

  /// Sets what joining each two regions would lose, and the threshold (RegionEdge). Nothing for
  /// rooms by shape. O(edges + places).
  /// @param regions  sets of places; those without a feature do not count
  void setMergeLosses(const std::vector<RegionCluster>& regions, std::vector<RegionEdge>& edges);

  /// See SceneGraphBuilder. Of a region that small ones have joined, its largest cluster.
  std::string explainRegion(RegionId id);
  std::string explainPair(PlaceId a, PlaceId b);

  const PlaceGraphPtr& places() const { return places_; }  ///< never null
  CosineSummary summarizeCosines() const;                  ///< of the places to the tasks
  const TaskList& tasks() const { return tasks_; }

 private:
  using PlaceKeys = std::pair<std::uint64_t, std::uint64_t>;

  /// A place that is in `clustering_`.
  struct Member {
    std::uint64_t key = 0;
    std::uint64_t feature_version = 0;
    std::uint32_t task = 0;  ///< that p(y|x) is largest for: 0 null, j = place task j - 1
  };

  PlaceUpdate apply(const PlaceGraphPtr& places);
  std::vector<Member> makeMembers(bool are_tasks_new) const;
  std::vector<PlaceKeys> listEdges(const std::vector<Member>& members) const;
  void replaceMembers(const std::vector<Member>& members, PlaceUpdate& update);
  void eraseEdges(const std::vector<PlaceKeys>& edges, PlaceUpdate& update);
  void insertEdges(const std::vector<PlaceKeys>& edges, PlaceUpdate& update);
  void updateClusters();
  void requireClustered(PlaceId id) const;
  RegionId findRegion(PlaceId place) const;
  /// A region as it was described last, and what its mean embedding was made of.
  struct Description;

  void describe(const RegionCluster& cluster, const std::unordered_set<std::uint64_t>& changed,
                Description& description) const;

  SceneGraphConfig config_;
  TaskList tasks_;
  bottleneck::TaskScorer scorer_;  ///< of `tasks_`
  std::unique_ptr<bottleneck::IncrementalClustering> clustering_;
  PlaceGraphPtr places_;
  std::unique_ptr<PlaceFeatures> features_;  ///< of `places_`
  std::vector<Member> members_;              ///< ascending by key
  std::vector<PlaceKeys> edges_;             ///< ... and the edges between them
  bool are_tasks_new_ = false;               ///< since `members_` was made
  std::unique_ptr<RegionIds> ids_;
  std::vector<RegionCluster> clusters_;         ///< ascending by id
  std::map<RegionId, std::unique_ptr<Description>> descriptions_;
  std::unordered_set<PlaceId> changed_places_;  ///< since then
  bool are_clusters_stale_ = true;
};

}  // namespace tsg::scene_graph
