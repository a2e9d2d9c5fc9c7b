// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/map/map.h"
#include "task_scene_graph/places/places_config.h"
#include "task_scene_graph/trajectory/correction.h"
#include "task_scene_graph/trajectory/deformation.h"

namespace tsg::trajectory {

/// How an object primitive moves: rigidly, blended evenly from the keyframes around its first, its
/// best and its last view. @throws std::invalid_argument as Correction::at().
Pose computeMotion(const ObjectPrimitive& primitive, const Keyframes& before,
                   const Correction& correction);

/// A primitive where its motion puts it; the same one if it does not move. @throws as above.
ObjectPrimitivePtr movePrimitive(const ObjectPrimitivePtr& primitive, const Keyframes& before,
                                 const Correction& correction);

/// The places where the deformation puts them; ids, clearances, edges and embeddings stay.
PlaceGraph movePlaces(const PlaceGraph& places, const Deformation& deformation,
                      int num_threads = 1);

/// Mesh blocks whose vertices follow the deformation, each triangle in the block in which it comes
/// to lie. Blocks in which nothing moves and nothing arrives are shared with those before. The same
/// for any number of threads.
std::vector<mapping::BlockMesh> moveMesh(const std::vector<mapping::BlockMesh>& blocks,
                                         double voxel_size_m, Deformation& deformation,
                                         int num_threads = 1);

/// What a map became.
struct CorrectedMap {
  map::Map map;
  std::size_t num_moved_primitives = 0;
  std::size_t num_moved_blocks = 0;  ///< of the mesh
};

/// A map that follows its trajectory. Ids, tasks, settings and clusters stay; what now overlaps is
/// not yet joined (see joinMap()). The place memory moves with it, without its ground plan, and the
/// occupancy map (OccupancyMap::moved()).
/// With the identity it is the same map: all parts are shared with it. O(primitives' vertices +
/// mesh vertices + voxels).
/// @param before  the keyframes that the map was made with, in its frame
/// @throws std::invalid_argument naming both frames if they differ; if there is no keyframe; as
/// Correction::at().
CorrectedMap correctMap(const map::Map& map, const Keyframes& before, const Correction& correction,
                        const DeformationConfig& config = {});

/// Finds places, passages and the ground plan anew in the place memory that a correction has moved;
/// places that are found where one was keep its id. Nothing for a map without free space.
/// O(voxels).
void updatePlaces(const places::PlacesConfig& config, map::Map& map);

/// Joins what lies on one another in a map that has moved: places and ground plan are found anew
/// (updatePlaces()), all primitives clustered anew, so that what was seen twice is one object.
/// Objects and regions keep their ids where they keep their members. @throws as map::recluster().
void joinMap(const places::PlacesConfig& config, map::Map& map);

}  // namespace tsg::trajectory
