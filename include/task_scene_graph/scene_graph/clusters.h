// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "task_scene_graph/bottleneck/relevance.h"
#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/scene_graph/scene_graph.h"

/// What the clustering finds, and what is published of it.
namespace tsg::scene_graph {

/// A cluster of object primitives, whether it is published as an object or not.
struct ObjectCluster {
  ObjectId id;   ///< stable; that of the object
  int task = 0;  ///< argmax of p(y given cluster): 0 null, j = object task j - 1
  std::vector<PrimitiveId> primitives;  ///< ascending, never empty
};

/// A cluster of places; each is a region.
struct RegionCluster {
  RegionId id;                  ///< stable; that of the region
  std::vector<PlaceId> places;  ///< ascending, never empty
};

/// The object that primitives are together, without id and place. Task and score are those of the
/// mean embedding; where the primitives disagree that may not be the cluster's most probable task.
/// @param members  with embeddings of one size, that of the tasks if there are any; not empty
/// @param tasks    names in the order of the scorer's rows
/// O(members * D + tasks * D).
SceneObject describeObject(const std::vector<const ObjectPrimitive*>& members,
                           const bottleneck::TaskScorer& scorer,
                           const std::vector<std::string>& tasks);

/// An object is published if its cluster's most probable task is not the null task, and the cosine
/// of its mean embedding to its best task reaches SceneGraphConfig::publishedFrom().
bool isPublished(int cluster_task, const SceneObject& object, const SceneGraphConfig& config);

/// The region that places are together, without id, doors and objects; named if its score reaches
/// `place_alpha`.
/// @param members  ascending by id, not empty; embeddings that are missing, zero or of another size
/// than the tasks' (without tasks: than the first) do not count. O(members * D + tasks * D).
Region describeRegion(const std::vector<const Place*>& members,
                      const bottleneck::TaskScorer& scorer, const std::vector<std::string>& tasks,
                      double place_alpha);
/// The same where the members' mean embedding is known. O(members + tasks * D).
Region describeRegion(const std::vector<const Place*>& members, Embedding mean,
                      const bottleneck::TaskScorer& scorer, const std::vector<std::string>& tasks,
                      double place_alpha);

/// Sets the place of each object to the nearest one, none without places. See PointIndex.
void setNearestPlaces(const PlaceGraph& places, std::vector<SceneObject>& objects);

}  // namespace tsg::scene_graph
