// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/thin_surfaces.h"

#include <algorithm>
#include <cmath>

namespace tsg::mapping {
namespace {

constexpr float kMinShare = 0.5F;        ///< of a voxel's weight, for a surface to be measured
constexpr double kReadingsAcross = 4.0;  ///< a voxel at the end of the range, at least

/// Every nth pixel is read along u and v.
int computeStride(const IntegratorConfig& config, const CameraModel& camera) {
  const double voxel_px =
      config.voxel_size_m * std::min(camera.fx_px, camera.fy_px) / config.max_range_m;
  return std::max(1, static_cast<int>(voxel_px / kReadingsAcross));
}

std::size_t computeLinear(const GridIndex& voxel) {
  return static_cast<std::size_t>(
      TsdfBlock::computeLinearIndex(TsdfVolume::computeLocalIndex(voxel)));
}

/// True if the TSDF knows of no surface here: this voxel and the six beside it were observed free,
/// and none of the 26 around is solid.
bool isInFreeSpace(const TsdfVolume& volume, const GridIndex& voxel) {
  for (int i = 0; i < 27; ++i) {
    const GridIndex step(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    const TsdfVoxel* found = volume.findVoxel(voxel + step);
    const bool is_observed = found != nullptr && found->weight > 0.0F;
    if (is_observed ? found->distance_m <= 0.0F : step.cwiseAbs().sum() <= 1) return false;
  }
  return true;
}

}  // namespace

std::vector<GridIndex> ThinSurfaces::add(const RgbdFrame& frame, const TsdfVolume& volume,
                                         const std::vector<GridIndex>& observed) {
  ++num_frames_;
  addReadings(frame, volume);
  std::vector<GridIndex> changed;
  for (const GridIndex& index : observed) {
    const auto counted = blocks_.find(index);
    const TsdfBlock* block = volume.findBlock(index);
    if (counted == blocks_.end() || block == nullptr) continue;
    if (updateMeasured(*block, counted->second)) changed.push_back(index);
  }
  return changed;
}

void ThinSurfaces::addReadings(const RgbdFrame& frame, const TsdfVolume& volume) {
  const int stride = computeStride(config_, frame.camera);
  const Pose T_camera_world = frame.T_world_camera.inverse();
  GridIndex last = GridIndex::Zero();
  Block* block = nullptr;
  bool is_first = true;
  for (int v = 0; v < frame.depth.image.rows; v += stride) {
    for (int u = 0; u < frame.depth.image.cols; u += stride) {
      const auto z_m = static_cast<double>(frame.depth.at(u, v));
      if (!(z_m > 0.0) || z_m < config_.min_range_m || z_m > config_.max_range_m) continue;
      const GridIndex voxel =
          volume.computeVoxelIndex(frame.T_world_camera * frame.camera.unproject(u, v, z_m));
      const GridIndex index = TsdfVolume::computeBlockIndex(voxel);
      if (is_first || index != last) {
        block = volume.findBlock(index) == nullptr ? nullptr : &blocks_[index];
        last = index;
        is_first = false;
      }
      if (block == nullptr) continue;
      const std::size_t i = computeLinear(voxel);
      if (!countReading(block->readings[i])) continue;
      const Eigen::Vector3d center_m = T_camera_world * volume.computeVoxelCenter(voxel);
      block->weight[i] = std::min(block->weight[i] + computeWeight(frame, center_m.z()),
                                  static_cast<float>(config_.max_weight));
    }
  }
}

/// `readings` is 0 before the first one, 2n after one reading of frame n, 2n + 1 after more.
/// @returns true for the second reading of this frame
bool ThinSurfaces::countReading(std::uint32_t& readings) const {
  const bool is_second = readings == 2 * num_frames_;
  if (is_second) {
    ++readings;
  } else if (readings != 2 * num_frames_ + 1) {
    readings = 2 * num_frames_;
  }
  return is_second;
}

float ThinSurfaces::computeWeight(const RgbdFrame& frame, double z_m) const {
  if (config_.weighting == Weighting::kConstant) return 1.0F;
  const double voxel_m = config_.voxel_size_m / std::max(z_m, config_.voxel_size_m);
  return static_cast<float>(frame.camera.fx_px * frame.camera.fy_px * voxel_m * voxel_m /
                            (z_m * z_m));
}

/// @returns whether any voxel began or ceased to be measured
bool ThinSurfaces::updateMeasured(const TsdfBlock& block, Block& counted) {
  VoxelSet is_measured;
  for (std::size_t i = 0; i < block.voxels.size(); ++i) {
    const float weight = block.voxels[i].weight;
    is_measured[i] = weight > 0.0F && counted.weight[i] >= kMinShare * weight;
  }
  const bool is_changed = is_measured != counted.is_measured;
  counted.is_measured = is_measured;
  return is_changed;
}

void ThinSurfaces::mark(const TsdfVolume& volume, TsdfBlock& copy) const {
  const auto counted = blocks_.find(copy.index);
  if (counted == blocks_.end()) return;
  for (std::size_t i = 0; i < copy.voxels.size(); ++i) {
    TsdfVoxel& voxel = copy.voxels[i];
    if (!counted->second.is_measured[i] || voxel.distance_m <= 0.0F) continue;
    const auto linear = static_cast<int>(i);
    const GridIndex local(linear % kBlockSide, linear / kBlockSide % kBlockSide,
                          linear / (kBlockSide * kBlockSide));
    if (isInFreeSpace(volume, copy.index * kBlockSide + local)) voxel.distance_m = 0.0F;
  }
}

}  // namespace tsg::mapping
