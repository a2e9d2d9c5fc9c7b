// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "task_scene_graph/places/dense_grid.h"
#include "task_scene_graph/places/ground_map.h"
#include "task_scene_graph/places/places_config.h"
#include "task_scene_graph/places/voxel_map.h"

namespace tsg::places {

/// Observed free cells with their clearance, as a ground plan (size z = 1) or a volume.
struct FreeSpace {
  GridExtent extent;
  double voxel_size_m = 0.0;
  std::vector<char> is_free;
  std::vector<float> clearance_m;    ///< of free cells: to the nearest obstacle, at most the limit
  std::vector<std::int32_t> parent;  ///< linear index of that obstacle, or NearestField::kNone
  std::vector<float> height_m;       ///< ground plan only: world z at which places lie

  bool isPlan() const { return !height_m.empty(); }
  /// World position of a cell.
  Eigen::Vector3d computePosition(std::size_t cell) const;
};

/// Clearance from obstacle cells. A cell's distance to an obstacle is that of the centres plus the
/// obstacle's own signed distance (at most half a voxel diagonal), so walls between voxel centres
/// keep their true place; cells without an obstacle within the limit have that limit as clearance.
void computeClearance(const std::vector<char>& is_obstacle, const std::vector<float>& offset_m,
                      double max_distance_m, FreeSpace& space);

/// Free = the floor's columns, and columns at most `max_floor_gap_m` beside them whose upper half
/// (of `body_height_m`) was observed free; obstacle = a column with something solid between
/// `max_step_m` and `body_height_m` above the nearest walkable column's ground.
FreeSpace makeWalkableSpace(const VoxelMap& voxels, const Floor& floor, const PlacesConfig& config);

/// Free = observed voxels with positive distance; obstacle = observed voxels with others; of these
/// block columns.
FreeSpace makeVolumeSpace(const VoxelMap& voxels, const std::vector<VoxelMap::ColumnIndex>& columns,
                          const PlacesConfig& config);

/// Cells of the generalised Voronoi diagram: free, clearance >= min_clearance_m, and beside a free
/// cell with such clearance whose nearest obstacle is a different one (see
/// min_parent_separation_m, max_parent_cosine). O(cells).
std::vector<char> findVoronoiCells(const FreeSpace& space, const PlacesConfig& config);

/// Smallest clearance of the cells on the straight line between two cells; 0 if one is not free.
double computeLineClearance(const FreeSpace& space, std::size_t from, std::size_t to);

}  // namespace tsg::places
