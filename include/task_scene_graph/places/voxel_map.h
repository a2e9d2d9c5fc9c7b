// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include "task_scene_graph/mapping/tsdf_volume.h"
#include "task_scene_graph/places/place_memory.h"

namespace tsg::places {

using mapping::GridIndex;

/// Signed distance of a voxel that was never observed.
constexpr float kNotObserved = std::numeric_limits<float>::quiet_NaN();

inline bool isNotObserved(float distance_m) { return distance_m != distance_m; }
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

  /// Takes blocks as they were remembered, in the place of all there is.
  void restore(double voxel_size_m, const std::vector<VoxelBlock>& blocks);

  /// 0 before the first copy.
  double voxelSize() const { return voxel_size_m_; }

  /// Distance of a voxel, kNotObserved where nothing was observed. O(log blocks).
  float at(const GridIndex& voxel) const;

  /// A column of voxels, from the bottom of its lowest block up.
  struct Column {
    int min_z = 0;  ///< voxel index of distances_m[0]
    std::vector<float> distances_m;
  };

  /// Calls `visit(offset, column)` for each of the 8 x 8 columns (offset: x fastest) and each run
  /// of blocks that lie on one another, from below. O(voxels of the block column).
  template <typename Visit>
  void forEachRun(const ColumnIndex& index, Visit visit) const {
    const auto found = columns_.find(index);
    if (found == columns_.end()) return;
    Column column;
    for (auto first = found->second.begin(); first != found->second.end();) {
      auto last = std::next(first);
      while (last != found->second.end() && last->first == std::prev(last)->first + 1) ++last;
      column.min_z = first->first * mapping::kBlockSide;
      for (int offset = 0; offset < 64; ++offset) {
        column.distances_m.clear();
        for (auto block = first; block != last; ++block) {
          for (int z = 0; z < mapping::kBlockSide; ++z) {
            column.distances_m.push_back(
                (*block->second)[static_cast<std::size_t>(offset + 64 * z)]);
          }
        }
        visit(offset, column);
      }
      first = last;
    }
  }

  /// Calls `visit(z, distance_m)` for the voxels of a column from `first_z` up to `last_z`, as far
  /// as there are blocks, until it returns false. O(blocks + voxels).
  template <typename Visit>
  void forEachInColumn(int x, int y, int first_z, int last_z, Visit visit) const {
    const auto found = columns_.find({x >> 3, y >> 3});
    if (found == columns_.end()) return;
    const auto& blocks = found->second;
    const auto column = static_cast<std::size_t>((x & 7) + 8 * (y & 7));
    for (auto block = blocks.lower_bound(first_z >> 3); block != blocks.end(); ++block) {
      const int base_z = block->first * mapping::kBlockSide;
      if (base_z > last_z) return;
      for (int z = std::max(first_z, base_z); z <= std::min(last_z, base_z + 7); ++z) {
        const auto at = column + 64 * static_cast<std::size_t>(z - base_z);
        if (!visit(z, (*block->second)[at])) return;
      }
    }
  }

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
