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
};

/// Two regions, a < b, of which at least two places are joined.
struct RegionEdge {
  RegionId a;
  RegionId b;
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

/// The pairs of regions of which places are joined; ascending. O(edges * log(places)).
std::vector<RegionEdge> computeRegionEdges(const SceneGraph& graph);

}  // namespace tsg::scene_graph
