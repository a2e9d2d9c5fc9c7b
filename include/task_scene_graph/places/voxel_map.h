// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <limits>
#include <map>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include "task_scene_graph/mapping/tsdf_volume.h"

namespace tsg::places {

using mapping::GridIndex;

/// Signed distance of a voxel that was never observed.
constexpr float kNotObserved = std::numeric_limits<float>::quiet_NaN();

inline bool isUnknown(float distance_m) { return distance_m != distance_m; }
inline bool isFree(float distance_m) { return distance_m > 0.0F; }
inline bool isSolid(float distance_m) { return distance_m <= 0.0F; }

/// Signed distances of all voxels ever observed: what places need of a TSDF volume, kept when the
/// volume itself drops a block.
class VoxelMap {
 public:
  /// Horizontal position of a column of blocks, in blocks.
  using ColumnIndex = std::pair<int, int>;

  /// Copies the blocks that the volume has. @returns the block columns touched, ascending.
  /// @throws std::invalid_argument if the volume's voxel size is not that of the first call.
  std::vector<ColumnIndex> copyBlocks(const mapping::TsdfVolume& volume,
                                      const std::vector<GridIndex>& blocks);

  /// 0 before the first copy.
  double voxelSize() const { return voxel_size_m_; }

  /// Distance of a voxel, kNotObserved where nothing was observed. O(log blocks).
  float at(const GridIndex& voxel) const;

  /// A column of voxels, from the bottom of its lowest block up.
  struct Column {
    int min_z = 0;  ///< voxel index of distances_m[0]
    std::vector<float> distances_m;
  };

  /// The 8 x 8 columns of a block column, x fastest. Empty distances if there is no block.
  std::array<Column, 64> readColumns(const ColumnIndex& index) const;

  /// Smallest box of voxels that holds every block of these columns; false if there is none.
  bool computeBounds(const std::vector<ColumnIndex>& columns, GridIndex& min, GridIndex& max) const;

  /// All block columns, ascending.
  std::vector<ColumnIndex> columnIndices() const;

  using Block = std::array<float, mapping::kBlockVoxels>;
  using BlockColumn = std::map<int, std::unique_ptr<Block>>;  ///< by z of the block
  const std::map<ColumnIndex, BlockColumn>& columns() const { return columns_; }

 private:
  double voxel_size_m_ = 0.0;
  std::map<ColumnIndex, BlockColumn> columns_;
};

/// Divides block columns into islands: columns of different islands are more than `reach_blocks`
/// apart along x or y, so that dense grids of each need not span the space between them (a single
/// frame whose pose is off by kilometres makes such an island). Islands ascend by their first
/// column, as do the columns in each. O(n log n).
std::vector<std::vector<VoxelMap::ColumnIndex>> splitIntoIslands(
    const std::vector<VoxelMap::ColumnIndex>& columns, int reach_blocks);

}  // namespace tsg::places
