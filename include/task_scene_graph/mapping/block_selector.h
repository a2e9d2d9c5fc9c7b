// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/mapping/depth_buffer.h"
#include "task_scene_graph/mapping/tsdf_volume.h"

namespace tsg::mapping {

/// A set of grid indices that remembers the order of insertion; open addressing.
class GridIndexSet {
 public:
  void clear();
  /// True if the index was not in the set. O(1) amortised.
  bool insert(const GridIndex& index);
  const std::vector<GridIndex>& indices() const { return indices_; }

 private:
  void grow();

  std::vector<GridIndex> indices_;
  std::vector<std::uint32_t> slots_;  ///< 1 + position in indices_, 0 = free; size a power of two
};

/// Finds the blocks that a depth image says something about: all that meet the truncation band
/// (depth - truncation .. depth + truncation) of any valid pixel, and with `carve_free_space` also
/// all between the camera and that band. Never misses such a block; may name a few more.
///
/// Squares of pixels with nearly equal depth are treated as one thick ray, others are quartered.
class BlockSelector {
 public:
  struct Options {
    double block_size_m = 0.4;
    double truncation_m = 0.2;
    double min_range_m = 0.3;  ///< where carving begins
    bool carve_free_space = false;
  };

  /// The blocks in the order in which they were found. The reference stays valid until the next
  /// call.
  const std::vector<GridIndex>& select(const DepthBuffer& depth, const CameraModel& camera,
                                       const Pose& T_world_camera, const Options& options);

  /// Side of a tile, pixels: the power of two up to 16 with which a tile is at most a quarter of a
  /// block wide at `max_range_m`.
  static int computeTileSide(const CameraModel& camera, double block_size_m, double max_range_m);

 private:
  /// Block coordinates relative to first_block_; the fourth number is 0, for vector instructions.
  struct BlockBox {
    Eigen::Array4i min;
    Eigen::Array4i max;
  };

  void setView(const CameraModel& camera, const Pose& T_world_camera);
  void addSquare(const DepthBuffer& depth, int u_px, int v_px, int side_px,
                 const DepthLimits& limits);
  void addRay(float u_px, float v_px, int side_px, const DepthLimits& limits);
  void addSegment(const Eigen::Array4f& direction, float near_m, float far_m, float margin);
  void addBox(const BlockBox& box);

  Options options_;
  GridIndex first_block_;
  Eigen::Array4f origin_;     ///< the camera, in blocks from first_block_
  Eigen::Array4f direction_;  ///< of pixel (0, 0), in blocks per metre of depth
  Eigen::Array4f direction_per_u_;
  Eigen::Array4f direction_per_v_;
  float half_width_per_m_ = 0.0F;  ///< of a pixel: half its diagonal, in blocks per metre of depth
  GridIndexSet set_;
  std::vector<BlockBox> latest_;  ///< by piece of the segment: neighbours mostly repeat them
};

}  // namespace tsg::mapping
