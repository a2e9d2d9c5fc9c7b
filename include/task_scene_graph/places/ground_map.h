// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <map>
#include <vector>

#include "task_scene_graph/places/dense_grid.h"
#include "task_scene_graph/places/places_config.h"
#include "task_scene_graph/places/voxel_map.h"

namespace tsg::places {

/// One connected floor: ground plan of the columns in which a body can stand.
struct Floor {
  GridExtent extent;            ///< size z = 1
  std::vector<float> height_m;  ///< world z of the ground in each column; NaN = not walkable
};

/// A standing place of one column.
struct GroundNode {
  int x = 0;  ///< voxel column
  int y = 0;
  float height_m = 0.0F;
};

/// Finds observed ground with `body_height_m` of observed free space above it, and joins it to
/// floors over steps of at most `max_step_m`. Patches across a gap of up to twice
/// `max_floor_gap_m` are the same floor, but only floors of `min_floor_area_m2` without any gap
/// count, with the patches around them. Columns at the upper edge of a drop are no floor.
class GroundMap {
 public:
  explicit GroundMap(const PlacesConfig& config) : config_(config) {}

  /// Looks again at the given block columns.
  void updateColumns(const VoxelMap& voxels, const std::vector<VoxelMap::ColumnIndex>& changed);

  /// All floors, largest first (then by position). O(ground plan of each island of columns).
  std::vector<Floor> computeFloors(double voxel_size_m) const;

 private:
  std::vector<GroundNode> collectNodes(const std::vector<VoxelMap::ColumnIndex>& columns) const;
  /// @param gap  longest step over columns without ground
  void addFloors(std::vector<GroundNode> nodes, int gap, double voxel_size_m,
                 std::vector<std::vector<GroundNode>>& floors) const;

  PlacesConfig config_;
  /// Heights of ground in the 8 x 8 columns of a block column, ascending.
  std::map<VoxelMap::ColumnIndex, std::array<std::vector<float>, 64>> heights_m_;
};

/// World z of every ground in a column: a solid voxel under `body_height_m` of free voxels, the
/// height interpolated between them; ascending.
std::vector<float> findGround(const VoxelMap::Column& column, double voxel_size_m,
                              double body_height_m);

}  // namespace tsg::places
