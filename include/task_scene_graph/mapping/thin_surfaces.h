// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/mapping/tsdf_integrator.h"
#include "task_scene_graph/mapping/tsdf_volume.h"

namespace tsg::mapping {

/// Finds surfaces that a carved TSDF loses. The TSDF reads depth along the ray through a voxel's
/// centre, so what is thinner than a voxel and lies between two such rays (the post of a door, the
/// leg of a table) is carved away, however often it was measured.
///
/// For each voxel the weights w_z (see TsdfIntegrator) of the frames with at least two readings
/// inside it are summed, H. A surface counts as measured in the voxel where H >= W / 2, W the
/// voxel's weight in the TSDF: things that went away are forgotten as they are there. What the TSDF
/// shows already is left to it: a measured voxel is a thin surface if it and the six beside it
/// were observed free and none of the 26 around is solid.
///
/// deviation: upstream carves with a TSDF alone. OctoMap lets readings win over rays that pass, as
/// here, but has no distances below a voxel [Hornung et al. 2013].
///
/// Not thread-safe.
class ThinSurfaces {
 public:
  /// @param config  of the integrator that makes the volume
  explicit ThinSurfaces(const IntegratorConfig& config) : config_(config) {}

  /// Counts a frame after it was integrated into the volume. @param observed  the blocks that
  /// changed in any way. @returns those of them in which a voxel began or ceased to be measured.
  /// O(readings + voxels of observed blocks with surfaces).
  std::vector<GridIndex> add(const RgbdFrame& frame, const TsdfVolume& volume,
                             const std::vector<GridIndex>& observed);

  /// Gives thin surfaces the distance 0 in a copy of one of the volume's blocks, by what the volume
  /// and its neighbouring blocks are now. O(measured voxels).
  void mark(const TsdfVolume& volume, TsdfBlock& copy) const;

  /// Forgets a block, for one that the volume drops. O(1).
  void erase(const GridIndex& block) { blocks_.erase(block); }

 private:
  using VoxelSet = std::bitset<static_cast<std::size_t>(kBlockVoxels)>;
  struct Block {
    std::array<float, kBlockVoxels> weight{};            ///< H
    std::array<std::uint32_t, kBlockVoxels> readings{};  ///< the newest frame's; see countReading()
    VoxelSet is_measured;
  };

  void addReadings(const RgbdFrame& frame, const TsdfVolume& volume);
  bool countReading(std::uint32_t& readings) const;
  float computeWeight(const RgbdFrame& frame, double z_m) const;
  static bool updateMeasured(const TsdfBlock& block, Block& counted);

  IntegratorConfig config_;
  std::uint32_t num_frames_ = 0;
  std::unordered_map<GridIndex, Block, GridIndexHash> blocks_;
};

}  // namespace tsg::mapping
