// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "task_scene_graph/core/frame.h"

namespace tsg::tracking {

/// One voxel of an infinite grid as one number: 21 bits per axis, each coordinate shifted by 2^20.
using VoxelKey = std::uint64_t;

/// Voxel coordinates a key can hold lie in [-kVoxelLimit, kVoxelLimit).
constexpr int kVoxelLimit = 1 << 20;

/// Packs the coordinates of a voxel. Precondition: each lies in [-kVoxelLimit, kVoxelLimit).
inline VoxelKey packVoxel(int x, int y, int z) {
  const auto pack = [](int value) { return static_cast<VoxelKey>(value + kVoxelLimit); };
  return pack(z) << 42 | pack(y) << 21 | pack(x);
}

Eigen::Vector3i unpackVoxel(VoxelKey key);

/// A sparse set of voxels in the world frame.
struct VoxelSet {
  std::vector<VoxelKey> keys;  ///< ascending, no key twice
  Eigen::AlignedBox3i box;     ///< inclusive voxel coordinates; empty if there is no voxel

  std::size_t size() const { return keys.size(); }
};

/// How many voxels two sets share. O(|a| + |b|).
std::size_t countShared(const VoxelSet& a, const VoxelSet& b);

/// |a intersected with b| / |a united with b| in [0, 1]; 0 if both are empty. O(|a| + |b|).
double computeIoU(const VoxelSet& a, const VoxelSet& b);

/// False only if IoU(a, b) < min_iou or the sets share no voxel: looks at boxes and sizes. O(1).
bool mayReachIoU(const VoxelSet& a, const VoxelSet& b, double min_iou);

/// Which pixels of a segment become points.
struct PixelFilter {
  double voxel_size_m = 0.1;
  double max_range_m = 5.0;  ///< distance from the camera centre, not depth
};

/// The surface that one segment of a frame shows.
struct SegmentPoints {
  std::size_t pixels = 0;  ///< with valid depth within range
  VoxelSet voxels;
};

/// The voxels of every segment: entry s-1 for label s; labels above `num_segments` are left out.
/// Preconditions: label image and depth have the camera's size, every point within range has voxel
/// coordinates that fit a key. O(pixels + V log V) for V runs of pixels in the same voxel.
std::vector<SegmentPoints> computeSegmentPoints(const RgbdFrame& frame, const cv::Mat& labels,
                                                std::size_t num_segments,
                                                const PixelFilter& filter);

}  // namespace tsg::tracking
