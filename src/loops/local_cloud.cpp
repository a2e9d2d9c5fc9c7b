// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/loops/local_cloud.h"

#include <cmath>
#include <stdexcept>
#include <unordered_map>

#include "task_scene_graph/mapping/tsdf_volume.h"

namespace tsg::loops {
namespace {

constexpr float kLargestJump = 0.05F;  ///< of depth between two pixels, as a share of the depth

struct Mean {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
};

/// Between a pixel and its right and lower neighbours.
bool isSurface(const DepthImage& depth, int u_px, int v_px, float z_m) {
  const float largest_m = kLargestJump * z_m;
  return std::abs(depth.at(u_px + 1, v_px) - z_m) <= largest_m &&
         std::abs(depth.at(u_px, v_px + 1) - z_m) <= largest_m;
}

}  // namespace

Points downsample(const Points& points, float voxel_m) {
  if (!(voxel_m > 0.0F)) {
    throw std::invalid_argument("voxel of " + std::to_string(voxel_m) + " m, expected above 0");
  }
  std::unordered_map<mapping::GridIndex, std::size_t, mapping::GridIndexHash> indices;
  std::vector<Mean> means;
  for (const Eigen::Vector3f& p : points) {
    const mapping::GridIndex cell = (p / voxel_m).array().floor().cast<int>();
    const auto [entry, is_new] = indices.try_emplace(cell, means.size());
    if (is_new) means.emplace_back();
    means[entry->second].sum += p.cast<double>();
    means[entry->second].count += 1.0;
  }
  Points result;
  result.reserve(means.size());
  for (const Mean& mean : means) result.emplace_back((mean.sum / mean.count).cast<float>());
  return result;
}

Points makeCloud(const DepthImage& depth, const CameraModel& camera, float voxel_m,
                 float max_range_m) {
  Points points;
  for (int v = 0; v + 1 < depth.image.rows; ++v) {
    for (int u = 0; u + 1 < depth.image.cols; ++u) {
      const float z_m = depth.at(u, v);
      if (z_m <= 0.0F || z_m > max_range_m || !isSurface(depth, u, v, z_m)) continue;
      points.push_back(camera.unproject(u, v, static_cast<double>(z_m)).cast<float>());
    }
  }
  return downsample(points, voxel_m);
}

Points transform(const Pose& T_a_b, const Points& points) {
  const Eigen::Isometry3f T = T_a_b.cast<float>();
  Points result;
  result.reserve(points.size());
  for (const Eigen::Vector3f& p : points) result.push_back(T * p);
  return result;
}

}  // namespace tsg::loops
