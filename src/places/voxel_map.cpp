// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/places/voxel_map.h"

#include <algorithm>
#include <set>
#include <sstream>
#include <stdexcept>

#include "task_scene_graph/places/ground_plan.h"

namespace tsg::places {
namespace {

using mapping::kBlockSide;

/// A voxel once observed stays so, also when its block was dropped and begun anew.
void copyDistances(const mapping::TsdfBlock& from, VoxelMap::Block& to) {
  for (std::size_t i = 0; i < to.size(); ++i) {
    const mapping::TsdfVoxel& voxel = from.voxels[i];
    if (voxel.weight > 0.0F) to[i] = voxel.distance_m;
  }
}

std::size_t computeLinear(const GridIndex& voxel) {
  return static_cast<std::size_t>(
      mapping::TsdfBlock::computeLinearIndex(mapping::TsdfVolume::computeLocalIndex(voxel)));
}

/// Gives all cells that hang together with this one the number of its island.
void spreadIsland(const VoxelMap::ColumnIndex& from, std::size_t island,
                  std::map<VoxelMap::ColumnIndex, std::size_t>& island_of_cell) {
  std::vector<VoxelMap::ColumnIndex> reached{from};
  island_of_cell.at(from) = island;
  while (!reached.empty()) {
    const auto [x, y] = reached.back();
    reached.pop_back();
    for (int i = 0; i < 9; ++i) {
      const auto next = island_of_cell.find({x + i % 3 - 1, y + i / 3 - 1});
      if (next == island_of_cell.end() || next->second == island) continue;
      next->second = island;
      reached.push_back(next->first);
    }
  }
}

}  // namespace

std::vector<VoxelMap::ColumnIndex> VoxelMap::copyBlocks(const mapping::TsdfVolume& volume,
                                                        const std::vector<GridIndex>& blocks) {
  if (voxel_size_m_ == 0.0) voxel_size_m_ = volume.voxelSize();
  if (voxel_size_m_ != volume.voxelSize()) {
    std::ostringstream message;
    message << "free-space volume has voxels of " << volume.voxelSize() << " m, expected "
            << voxel_size_m_ << " m as before";
    throw std::invalid_argument(message.str());
  }
  std::set<ColumnIndex> touched;
  for (const GridIndex& index : blocks) {
    const mapping::TsdfBlock* block = volume.findBlock(index);
    if (block == nullptr) continue;
    auto& copy = columns_[{index.x(), index.y()}][index.z()];
    if (!copy) {
      copy = std::make_unique<Block>();
      copy->fill(kNotObserved);
    }
    copyDistances(*block, *copy);
    touched.insert({index.x(), index.y()});
  }
  return {touched.begin(), touched.end()};
}

void VoxelMap::restore(double voxel_size_m, const std::vector<VoxelBlock>& blocks) {
  voxel_size_m_ = voxel_size_m;
  columns_.clear();
  for (const VoxelBlock& block : blocks) {
    auto& copy = columns_[{block.index.x(), block.index.y()}][block.index.z()];
    copy = std::make_unique<Block>(block.distances_m);
  }
}

float VoxelMap::at(const GridIndex& voxel) const {
  const GridIndex index = mapping::TsdfVolume::computeBlockIndex(voxel);
  const auto column = columns_.find({index.x(), index.y()});
  if (column == columns_.end()) return kNotObserved;
  const auto block = column->second.find(index.z());
  return block == column->second.end() ? kNotObserved : (*block->second)[computeLinear(voxel)];
}

std::vector<VoxelMap::ColumnIndex> VoxelMap::columnIndices() const {
  std::vector<ColumnIndex> indices;
  indices.reserve(columns_.size());
  for (const auto& [index, blocks] : columns_) indices.push_back(index);
  return indices;
}

std::vector<std::vector<VoxelMap::ColumnIndex>> splitIntoIslands(
    const std::vector<VoxelMap::ColumnIndex>& columns, int reach_blocks) {
  // Columns within reach lie in the same cell of this size or in cells that touch.
  const int side = std::max(8, reach_blocks);
  const auto toCell = [&](const VoxelMap::ColumnIndex& column) {
    return VoxelMap::ColumnIndex(divideFloor(column.first, side), divideFloor(column.second, side));
  };
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::map<VoxelMap::ColumnIndex, std::size_t> island_of_cell;
  for (const auto& column : columns) island_of_cell[toCell(column)] = kNone;
  std::vector<std::vector<VoxelMap::ColumnIndex>> islands;
  for (const auto& column : columns) {
    auto& island = island_of_cell.at(toCell(column));
    if (island == kNone) {
      spreadIsland(toCell(column), islands.size(), island_of_cell);
      islands.emplace_back();
    }
    islands[island].push_back(column);
  }
  return islands;
}

}  // namespace tsg::places
