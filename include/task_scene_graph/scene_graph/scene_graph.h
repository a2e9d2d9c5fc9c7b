// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/scene_graph/config.h"

namespace tsg::scene_graph {

/// A task-relevant object: a cluster of object primitives [Clio24, Sec. IV-B].
struct SceneObject {
  ObjectId id;               ///< stable from snapshot to snapshot
  std::string task;          ///< name of the task it serves best
  int task_index = -1;       ///< index into SceneGraph::object_tasks
  double score = 0.0;        ///< cosine of `embedding` to that task's, in [-1, 1]
  Aabb box;                  ///< union of its primitives' boxes; world frame, metres
  OrientedBox oriented_box;  ///< least upright one that holds its primitives' oriented boxes
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< mean of their box centres; world frame
  std::vector<PrimitiveId> primitives;                   ///< ascending, never empty
  Embedding embedding;                                   ///< mean of its primitives' embeddings
  Stamp first_seen;
  Stamp last_seen;
  PlaceId place;  ///< nearest place to `position_m`; invalid while there is none
};

/// A cluster of places: a room, or what the place tasks make of it.
struct Region {
  RegionId id;          ///< stable from snapshot to snapshot
  std::string task;     ///< name of the place task it serves best, "" if none reaches place_alpha
  int task_index = -1;  ///< index into SceneGraph::place_tasks, -1 if none reaches place_alpha
  double score = 0.0;   ///< cosine of `embedding` to the best task's, named or not; 0 without tasks
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< of the place nearest to their mean
  std::vector<PlaceId> places;                           ///< ascending, never empty
  Embedding embedding;                                   ///< mean of its places' embeddings
  double area_m2 = 0.0;  ///< of the floor within the clearance of its places
  /// Outline of that floor, x and y in the world frame, counter-clockwise; of its largest part if
  /// there are several. Courtyards are not cut out.
  std::vector<Eigen::Vector2d> footprint_m;
  std::vector<PlaceId> doors;     ///< its places with an edge into another region, ascending
  std::vector<ObjectId> objects;  ///< whose nearest place is in it, ascending
};

/// Two regions, a < b, of which at least two places are joined, and why they are two.
struct RegionEdge {
  RegionId a;
  RegionId b;
  double passage_m = 0.0;  ///< clearance of the widest edge between them
  /// What joining the two would lose of the information on the place tasks [Clio24, Eq. 2], as it
  /// is compared with `merge_threshold`: half the bits, or the share of all (place_normaliser). A
  /// loss below the threshold: they are apart because merges that lead there lose more. Both are 0
  /// where they are not known: rooms by shape.
  double merge_loss = 0.0;
  double merge_threshold = 0.0;
};

/// One snapshot of the whole graph: primitives -> objects -> places -> regions. Immutable.
struct SceneGraph {
  Stamp stamp;              ///< newest primitive or place graph in it
  std::string world_frame;  ///< name of the frame that all coordinates are in
  SceneGraphConfig config;  ///< what it was clustered with
  std::vector<std::string> object_tasks;
  std::vector<std::string> place_tasks;
  std::vector<ObjectPrimitivePtr> primitives;  ///< ascending by id, also those of no object
  std::vector<SceneObject> objects;            ///< ascending by id
  PlaceGraphPtr places;                        ///< never null
  std::vector<Region> regions;           ///< ascending by id; a place without embedding is in none
  std::vector<RegionEdge> region_edges;  ///< ascending by (a, b)
};

using SceneGraphPtr = std::shared_ptr<const SceneGraph>;

/// Region of each place of `graph.places`, same order; invalid where a place is in none.
/// O(places * log(places)).
std::vector<RegionId> computeRegionOfPlaces(const SceneGraph& graph);

/// Region of each object of `graph.objects` (that of its nearest place), same order; invalid where
/// there is none. O((objects + places) * log(places)).
std::vector<RegionId> computeRegionOfObjects(const SceneGraph& graph);

/// Object of each primitive that is in one; ids as files with 32 bits hold them.
/// O(primitives * log(primitives)).
std::map<PrimitiveId, std::int32_t> computeObjectOfPrimitives(const SceneGraph& graph);

/// Sets the edges between regions (but for what merging loses), and of each region its doors and
/// its objects, from the regions' places and the objects' places. O((edges + objects) log(places)).
void connectRegions(SceneGraph& graph);

}  // namespace tsg::scene_graph
