// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/tsdf_volume.h"

#include <algorithm>
#include <tuple>

namespace tsg::mapping {

const TsdfBlock* TsdfVolume::findBlock(const GridIndex& block) const {
  const auto found = blocks_.find(block);
  return found == blocks_.end() ? nullptr : found->second.get();
}

TsdfBlock* TsdfVolume::findBlock(const GridIndex& block) {
  const auto found = blocks_.find(block);
  return found == blocks_.end() ? nullptr : found->second.get();
}

const TsdfVoxel* TsdfVolume::findVoxel(const GridIndex& voxel) const {
  const TsdfBlock* block = findBlock(computeBlockIndex(voxel));
  if (block == nullptr) return nullptr;
  return &block->voxels[static_cast<std::size_t>(
      TsdfBlock::computeLinearIndex(computeLocalIndex(voxel)))];
}

TsdfBlock& TsdfVolume::allocateBlock(const GridIndex& block) {
  auto& slot = blocks_[block];
  if (!slot) {
    slot = std::make_unique<TsdfBlock>();
    slot->index = block;
  }
  return *slot;
}

void TsdfVolume::removeBlock(const GridIndex& block) { blocks_.erase(block); }

std::vector<GridIndex> TsdfVolume::sortedBlockIndices() const {
  std::vector<GridIndex> indices;
  indices.reserve(blocks_.size());
  for (const auto& [index, block] : blocks_) indices.push_back(index);
  std::sort(indices.begin(), indices.end(), [](const GridIndex& a, const GridIndex& b) {
    return std::make_tuple(a.z(), a.y(), a.x()) < std::make_tuple(b.z(), b.y(), b.x());
  });
  return indices;
}

}  // namespace tsg::mapping
