// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/tracking/voxel_set.h"

#include <algorithm>
#include <cmath>

namespace tsg::tracking {
namespace {

void makeSet(VoxelSet& set) {
  std::sort(set.keys.begin(), set.keys.end());
  set.keys.erase(std::unique(set.keys.begin(), set.keys.end()), set.keys.end());
  for (const VoxelKey key : set.keys) set.box.extend(unpackVoxel(key));
}

/// Maps a pixel and its depth to the voxel that holds the point.
class PixelToVoxel {
 public:
  PixelToVoxel(const RgbdFrame& frame, const PixelFilter& filter)
      : camera_(frame.camera),
        rotation_(frame.T_world_camera.linear() / filter.voxel_size_m),
        translation_(frame.T_world_camera.translation() / filter.voxel_size_m),
        max_squared_range_m2_(filter.max_range_m * filter.max_range_m) {}

  /// False if the point is out of range.
  bool convert(int u_px, int v_px, double z_m, VoxelKey& key) const {
    const Eigen::Vector3d p_camera = camera_.unproject(u_px, v_px, z_m);
    if (p_camera.squaredNorm() > max_squared_range_m2_) return false;
    const Eigen::Vector3d p_voxels = rotation_ * p_camera + translation_;
    const auto floorToInt = [](double value) { return static_cast<int>(std::floor(value)); };
    key = packVoxel(floorToInt(p_voxels.x()), floorToInt(p_voxels.y()), floorToInt(p_voxels.z()));
    return true;
  }

 private:
  CameraModel camera_;
  Eigen::Matrix3d rotation_;
  Eigen::Vector3d translation_;
  double max_squared_range_m2_;
};

}  // namespace

Eigen::Vector3i unpackVoxel(VoxelKey key) {
  const auto unpack = [](VoxelKey bits) { return static_cast<int>(bits & 0x1FFFFF) - kVoxelLimit; };
  return {unpack(key), unpack(key >> 21), unpack(key >> 42)};
}

std::size_t countShared(const VoxelSet& a, const VoxelSet& b) {
  std::size_t shared = 0;
  auto left = a.keys.begin();
  auto right = b.keys.begin();
  while (left != a.keys.end() && right != b.keys.end()) {
    const bool is_equal = *left == *right;
    const bool is_less = *left < *right;
    shared += is_equal ? 1 : 0;
    left += (is_less || is_equal) ? 1 : 0;
    right += is_less ? 0 : 1;
  }
  return shared;
}

double computeIoU(const VoxelSet& a, const VoxelSet& b) {
  const std::size_t shared = countShared(a, b);
  const std::size_t united = a.size() + b.size() - shared;
  return united == 0 ? 0.0 : static_cast<double>(shared) / static_cast<double>(united);
}

bool mayReachIoU(const VoxelSet& a, const VoxelSet& b, double min_iou) {
  if (!a.box.intersects(b.box)) return false;
  const auto [smaller, larger] = std::minmax({a.size(), b.size()});
  return static_cast<double>(smaller) / static_cast<double>(larger) >= min_iou;
}

std::vector<SegmentPoints> computeSegmentPoints(const RgbdFrame& frame, const cv::Mat& labels,
                                                std::size_t num_segments,
                                                const PixelFilter& filter) {
  std::vector<SegmentPoints> segments(num_segments);
  const PixelToVoxel pixel_to_voxel(frame, filter);
  for (int v = 0; v < labels.rows; ++v) {
    const auto* label_row = labels.ptr<std::uint16_t>(v);
    for (int u = 0; u < labels.cols; ++u) {
      const std::size_t label = label_row[u];
      if (label == 0 || label > num_segments) continue;
      const double z_m = static_cast<double>(frame.depth.at(u, v));
      VoxelKey key = 0;
      if (z_m <= 0.0 || !pixel_to_voxel.convert(u, v, z_m, key)) continue;
      SegmentPoints& segment = segments[label - 1];
      ++segment.pixels;
      auto& keys = segment.voxels.keys;
      if (keys.empty() || keys.back() != key) keys.push_back(key);
    }
  }
  for (SegmentPoints& segment : segments) makeSet(segment.voxels);
  return segments;
}

}  // namespace tsg::tracking
