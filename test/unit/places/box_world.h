// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <functional>
#include <vector>

#include "task_scene_graph/core/box.h"
#include "task_scene_graph/mapping/tsdf_volume.h"

namespace tsg::places::test {

constexpr double kVoxel_m = 0.1;
constexpr double kTruncation_m = 0.3;

/// A world of solid boxes with a closed-form signed distance.
class BoxWorld {
 public:
  BoxWorld& add(const Eigen::Vector3d& min_m, const Eigen::Vector3d& max_m) {
    boxes_.push_back(makeAabb(min_m, max_m));
    return *this;
  }

  /// A floor 0.3 m thick with its top at `top_m`.
  BoxWorld& addFloor(double x0, double y0, double x1, double y1, double top_m = 0.0) {
    return add({x0, y0, top_m - 0.3}, {x1, y1, top_m});
  }

  /// Four walls of 0.2 m and a floor around the given inner rectangle.
  BoxWorld& addRoom(double x0, double y0, double x1, double y1, double height_m = 2.5) {
    addFloor(x0 - 0.2, y0 - 0.2, x1 + 0.2, y1 + 0.2);
    add({x0 - 0.2, y0 - 0.2, 0}, {x0, y1 + 0.2, height_m});
    add({x1, y0 - 0.2, 0}, {x1 + 0.2, y1 + 0.2, height_m});
    add({x0 - 0.2, y0 - 0.2, 0}, {x1 + 0.2, y0, height_m});
    return add({x0 - 0.2, y1, 0}, {x1 + 0.2, y1 + 0.2, height_m});
  }

  /// Distance to the nearest solid; negative inside of one, to its nearest face.
  double computeDistance(const Eigen::Vector3d& p) const {
    double nearest_m = 1e9;
    for (const Aabb& box : boxes_) {
      const double outside_m = box.exteriorDistance(p);
      const Eigen::Vector3d to_faces = (p - box.min()).cwiseMin(box.max() - p);
      nearest_m = std::min(nearest_m, outside_m > 0.0 ? outside_m : -to_faces.minCoeff());
    }
    return nearest_m;
  }

  /// Distance to the nearest solid as seen in the plane at height `z_m`.
  double computeHorizontalDistance(const Eigen::Vector3d& p, double z_m) const {
    double nearest_m = 1e9;
    for (const Aabb& box : boxes_) {
      if (box.min().z() >= z_m || box.max().z() <= z_m) continue;
      const Eigen::Vector3d at(p.x(), p.y(), z_m);
      nearest_m = std::min(nearest_m, box.exteriorDistance(at));
    }
    return nearest_m;
  }

 private:
  std::vector<Aabb> boxes_;
};

/// Writes what an ideal sensor would have seen inside `seen` into the volume: every voxel that is
/// free or at most the truncation deep. @returns the blocks touched.
inline std::vector<mapping::GridIndex> observe(
    const BoxWorld& world, const Aabb& seen, mapping::TsdfVolume& volume,
    const std::function<bool(const Eigen::Vector3d&)>& is_seen = {}) {
  const mapping::GridIndex min = volume.computeVoxelIndex(seen.min());
  const mapping::GridIndex max = volume.computeVoxelIndex(seen.max());
  mapping::TsdfVolume touched(volume.voxelSize());
  for (int z = min.z(); z <= max.z(); ++z) {
    for (int y = min.y(); y <= max.y(); ++y) {
      for (int x = min.x(); x <= max.x(); ++x) {
        const Eigen::Vector3d p = volume.computeVoxelCenter({x, y, z});
        const double distance_m = world.computeDistance(p);
        if (!seen.contains(p) || distance_m < -kTruncation_m || (is_seen && !is_seen(p))) continue;
        const auto block = mapping::TsdfVolume::computeBlockIndex({x, y, z});
        const auto local = mapping::TsdfVolume::computeLocalIndex({x, y, z});
        touched.allocateBlock(block);
        auto& voxel =
            volume.allocateBlock(block)
                .voxels[static_cast<std::size_t>(mapping::TsdfBlock::computeLinearIndex(local))];
        voxel.distance_m = static_cast<float>(std::min(distance_m, kTruncation_m));
        voxel.weight = 1.0F;
      }
    }
  }
  return touched.sortedBlockIndices();
}

}  // namespace tsg::places::test
