// SPDX-License-Identifier: BSD-3-Clause
#include "place_layers.h"

namespace tsg::places {
namespace {

/// Ground this near to the camera tells how high it is carried.
constexpr double kGroundRadius_m = 3.0;

}  // namespace

CellSet PlaceLayers::update(const VoxelMap& voxels, const TileSet& changed) {
  if (voxels.voxelSize() == 0.0) return {};
  if (config_.free_space == FreeSpaceKind::kWalkable) floors_.readGround(voxels, changed);
  TileSet dirty = way_.update(voxels.voxelSize(), [&](const Eigen::Vector3d& p_m) {
    return floors_.collectGround(p_m, kGroundRadius_m, voxels.voxelSize());
  });
  dirty.insert(changed.begin(), changed.end());
  return propagate(voxels, dirty);
}

CellSet PlaceLayers::updateAll(const VoxelMap& voxels, const WayMap& way) {
  way_ = way;
  TileSet all;
  for (const auto& index : voxels.columnIndices()) all.insert(index);
  if (config_.free_space == FreeSpaceKind::kWalkable) floors_.readGround(voxels, all);
  for (const auto& index : way.tileIndices()) all.insert(index);
  return propagate(voxels, all);
}

CellSet PlaceLayers::propagate(const VoxelMap& voxels, const TileSet& changed) {
  if (changed.empty()) return {};
  const bool is_plan = config_.free_space == FreeSpaceKind::kWalkable;
  const TileSet with_cells =
      is_plan ? space_.updateCells(voxels, floors_, changed, floors_.update(voxels, way_, changed))
              : space_.updateCells(voxels, way_, changed);
  TileSet tiles = space_.updateClearance(with_cells);
  if (is_plan) {
    if (plan_.cellSize() != voxels.voxelSize()) plan_ = GroundPlan(voxels.voxelSize());
    for (const TileIndex& index : tiles) plan_.setTiles(index, space_.makePlanTiles(index));
  }
  const TileSet with_voronoi = space_.updateVoronoi(tiles);
  tiles.insert(with_voronoi.begin(), with_voronoi.end());
  CoarseSet coarse = cells_.update(space_, tiles);
  const CoarseSet with_space = cells_.findCoarse(space_, tiles);
  coarse.insert(with_space.begin(), with_space.end());
  return links_.update(space_, cells_, coarse);
}

}  // namespace tsg::places
