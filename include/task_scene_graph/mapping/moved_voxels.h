// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/core/box.h"
#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/mapping/tsdf_volume.h"

namespace tsg::mapping {

/// The middle of a block of kBlockSide^3 voxels, in metres.
inline Eigen::Vector3d computeBlockMiddle(const GridIndex& block, double voxel_size_m) {
  return (block.cast<double>().array() + 0.5) * (voxel_size_m * kBlockSide);
}

/// The voxels of a block in other coordinates, resampled to the nearest: each target voxel asks for
/// the source voxel in which its centre lies, so there are no holes.
/// @param visit  void(const GridIndex& target, const GridIndex& source), x fastest
/// O(voxels of the moved block's hull).
template <typename Visit>
void forEachMovedVoxel(const GridIndex& block, double voxel_size_m, const Pose& T_target_source,
                       const Visit& visit) {
  const double side_m = voxel_size_m * kBlockSide;
  const Aabb source(block.cast<double>() * side_m,
                    (block.array() + 1).matrix().cast<double>() * side_m);
  Aabb box;
  for (int corner = 0; corner < 8; ++corner) {
    box.extend(T_target_source * source.corner(static_cast<Aabb::CornerType>(corner)));
  }
  const auto toVoxel = [&](const Eigen::Vector3d& p_m) -> GridIndex {
    return (p_m / voxel_size_m).array().floor().cast<int>();
  };
  const Pose T_source_target = T_target_source.inverse();
  const GridIndex first = toVoxel(box.min());
  const GridIndex size = toVoxel(box.max()) - first + GridIndex::Ones();
  for (int i = 0; i < size.prod(); ++i) {
    const GridIndex target =
        first + GridIndex(i % size.x(), i / size.x() % size.y(), i / (size.x() * size.y()));
    const Eigen::Vector3d center_m = (target.cast<double>().array() + 0.5) * voxel_size_m;
    const GridIndex from = toVoxel(T_source_target * center_m);
    if (TsdfVolume::computeBlockIndex(from) == block) visit(target, from);
  }
}

}  // namespace tsg::mapping
