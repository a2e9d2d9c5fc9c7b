// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "task_scene_graph/core/box.h"

namespace tsg::mapping {

/// Integer coordinates of a voxel or a block. Voxel i covers [i, i+1) * voxel_size_m; its distance
/// is that of its centre (i + 0.5) * voxel_size_m. Block b holds voxels [b, b+1) * kBlockSide.
using GridIndex = Eigen::Vector3i;

constexpr int kBlockSide = 8;
constexpr int kBlockVoxels = kBlockSide * kBlockSide * kBlockSide;

struct GridIndexHash {
  std::size_t operator()(const GridIndex& index) const {
    const auto mixed = static_cast<std::uint64_t>(index.x()) * 73856093ULL ^
                       static_cast<std::uint64_t>(index.y()) * 19349669ULL ^
                       static_cast<std::uint64_t>(index.z()) * 83492791ULL;
    return static_cast<std::size_t>(mixed * 0x9E3779B97F4A7C15ULL >> 17);
  }
};

/// Truncated signed distance to the nearest surface: positive in free space. weight 0 = never
/// observed.
struct TsdfVoxel {
  float distance_m = 0.0F;
  float weight = 0.0F;
};

/// RGB; `known` is 0 until a pixel near the surface has coloured the voxel. Four bytes, so that a
/// row of voxels is blended with vector instructions.
struct VoxelColor {
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;
  std::uint8_t known = 0;
};

/// 8 x 8 x 8 voxels, x fastest. Colours lie apart from distances: most readers need no colour.
struct TsdfBlock {
  GridIndex index = GridIndex::Zero();
  std::array<TsdfVoxel, kBlockVoxels> voxels{};
  std::array<VoxelColor, kBlockVoxels> colors{};

  static int computeLinearIndex(const GridIndex& local) {
    return local.x() + kBlockSide * (local.y() + kBlockSide * local.z());
  }
};

/// Sparse grid of TSDF blocks in the world frame (voxel-block hashing, Niessner et al. 2013).
class TsdfVolume {
 public:
  using Blocks = std::unordered_map<GridIndex, std::unique_ptr<TsdfBlock>, GridIndexHash>;

  explicit TsdfVolume(double voxel_size_m) : voxel_size_m_(voxel_size_m) {}

  double voxelSize() const { return voxel_size_m_; }
  const Blocks& blocks() const { return blocks_; }

  const TsdfBlock* findBlock(const GridIndex& block) const;
  TsdfBlock* findBlock(const GridIndex& block);
  /// The voxel, or nullptr if its block was never allocated. O(1).
  const TsdfVoxel* findVoxel(const GridIndex& voxel) const;
  /// The block, made of never observed voxels if it was not there. Pointers to blocks stay valid
  /// until the block is removed.
  TsdfBlock& allocateBlock(const GridIndex& block);
  void removeBlock(const GridIndex& block);

  GridIndex computeVoxelIndex(const Eigen::Vector3d& p_world) const {
    return (p_world / voxel_size_m_).array().floor().cast<int>();
  }
  Eigen::Vector3d computeVoxelCenter(const GridIndex& voxel) const {
    return (voxel.cast<double>().array() + 0.5) * voxel_size_m_;
  }
  static GridIndex computeBlockIndex(const GridIndex& voxel) {
    return {voxel.x() >> 3, voxel.y() >> 3, voxel.z() >> 3};
  }
  static GridIndex computeLocalIndex(const GridIndex& voxel) {
    return {voxel.x() & 7, voxel.y() & 7, voxel.z() & 7};
  }

  /// Block indices in ascending (z, y, x) order: the order in which results are written, so that
  /// they do not depend on the hash table's history.
  std::vector<GridIndex> sortedBlockIndices() const;

 private:
  double voxel_size_m_;
  Blocks blocks_;
};

}  // namespace tsg::mapping
