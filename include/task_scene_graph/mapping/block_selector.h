// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/mapping/depth_buffer.h"
#include "task_scene_graph/mapping/tsdf_volume.h"

namespace task_scene_graph::mapping {

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

  /// Side of a tile, pixels, so that a tile is about a quarter of a block wide at `max_range_m`.
  static int computeTileSide(const CameraModel& camera, double block_size_m, double max_range_m);

 private:
  struct BlockBox {
    GridIndex min;
    GridIndex max;
  };

  void addSquare(const DepthBuffer& depth, int u_px, int v_px, int side_px,
                 const DepthLimits& limits);
  void addRay(double u_px, double v_px, int side_px, const DepthLimits& limits);
  void addSegment(const Eigen::Vector3d& direction, double near_m, double far_m,
                  double half_width_at_1m);
  void addBox(const BlockBox& box);

  Options options_;
  CameraModel camera_;
  Pose T_world_camera_;
  GridIndexSet set_;
  std::vector<BlockBox> latest_;  ///< by piece of the segment: neighbours mostly repeat them
};

}  // namespace task_scene_graph::mapping
