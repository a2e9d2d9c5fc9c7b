// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/mapping/depth_buffer.h"
#include "task_scene_graph/mapping/tsdf_volume.h"

namespace tsg::mapping {

constexpr int kSliceVoxels = kBlockSide * kBlockSide;

/// How one depth reading changes a voxel; see IntegratorConfig for the formulas.
struct UpdateRule {
  float truncation_m = 0.2F;
  float drop_off_start_m = 0.05F;
  float constant_weight = 0.0F;  ///< weight of a reading: this ...
  float weight_at_1m = 1.0F;     ///< ... plus this over the voxel's depth^4
  float max_weight = 1e5F;
  float max_range_m = 1e9F;  ///< readings beyond it update only voxels within it
};

/// What of a frame the kernel needs, in single precision.
struct FrameView {
  FrameView(const RgbdFrame& frame, const DepthBuffer& depth, double voxel_size_m, bool with_color);

  const float* depth_m;
  std::int32_t width_px;
  std::int32_t height_px;
  float fx_px, fy_px;
  float cx_px, cy_px;  ///< half a pixel more than the camera's: truncation then rounds to nearest
  cv::Mat color;       ///< continuous, or empty: no colour wanted
  int red_shift = 0;   ///< position of a channel's bits in a pixel read as a number
  int blue_shift = 16;
  Pose T_camera_world;
  /// Camera coordinates of the voxels of a slice (64 voxels of equal z) less those of its first.
  std::array<float, kSliceVoxels> offset_x_m, offset_y_m, offset_z_m;
};

/// What a slice of voxels sees of the frame.
struct alignas(32) SliceView {
  std::array<float, kSliceVoxels> depth_m;       ///< reading at the voxel's pixel, 0 = none
  std::array<float, kSliceVoxels> z_m;           ///< the voxel's own depth
  std::array<float, kSliceVoxels> ray;           ///< length of its ray per metre of depth
  std::array<std::int32_t, kSliceVoxels> pixel;  ///< row-major index; width * height = outside
};

/// How many voxels of a block, by the meaning in SliceUpdate.
struct BlockUpdate {
  int observed = 0;
  int changed = 0;
};

/// What became of the voxels of a slice; the last three are 1 or 0.
struct alignas(32) SliceUpdate {
  std::array<float, kSliceVoxels> share;            ///< weight of the reading / weight after it
  std::array<std::int32_t, kSliceVoxels> observed;  ///< was updated
  std::array<std::int32_t, kSliceVoxels> changed;   ///< ... in a way that can move the mesh
  std::array<std::int32_t, kSliceVoxels> in_band;   ///< ... by a reading within the truncation
};

/// Projects the slice z of a block into the frame. False if no voxel of it sees a reading.
bool viewSlice(const FrameView& frame, const Eigen::Vector3f& first_voxel_camera_m,
               SliceView& slice);

/// Integrates the depth that a slice sees into its voxels (TsdfBlock::voxels from its first on).
void updateDistances(const UpdateRule& rule, const SliceView& slice, TsdfVoxel* voxels,
                     SliceUpdate& update);
/// Integrates the colours where `update` says that a reading was within the truncation.
void updateColors(const FrameView& frame, const SliceView& slice, const SliceUpdate& update,
                  VoxelColor* colors);

/// Sum over a slice.
std::int32_t computeSum(const std::array<std::int32_t, kSliceVoxels>& values);

/// Integrates the frame into all voxels of a block.
BlockUpdate updateBlock(const FrameView& frame, const UpdateRule& rule, double voxel_size_m,
                        TsdfBlock& block);

/// Camera coordinates of the first voxel of each of the block's slices.
std::array<Eigen::Vector3f, kBlockSide> computeSliceOrigins(const FrameView& frame,
                                                            double voxel_size_m,
                                                            const GridIndex& block);

}  // namespace tsg::mapping
