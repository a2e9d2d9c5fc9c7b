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

/// The places where the deformation puts them; ids, clearances, edges and embeddings stay.
PlaceGraph movePlaces(const PlaceGraph& places, const Deformation& deformation);

/// Mesh blocks whose vertices follow the deformation, each triangle in the block in which it comes
/// to lie. Blocks in which nothing moves and nothing arrives are shared with those before.
std::vector<mapping::BlockMesh> moveMesh(const std::vector<mapping::BlockMesh>& blocks,
                                         double voxel_size_m, Deformation& deformation);

/// What a map became.
struct CorrectedMap {
  map::Map map;
  std::size_t num_moved_primitives = 0;
  std::size_t num_moved_blocks = 0;    ///< of the mesh
  bool has_dropped_occupancy = false;  ///< an octree cannot be bent; it must be filled anew
};

/// A map that follows its trajectory. Ids, tasks, settings and clusters stay; what now overlaps is
/// not yet joined. The place memory moves with it, without its ground plan (see updatePlaces()).
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

}  // namespace tsg::trajectory
