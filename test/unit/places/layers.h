// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "box_world.h"
#include "graph_checks.h"
#include "places/place_layers.h"
#include "sparse_config.h"
#include "task_scene_graph/places/place_extractor.h"

namespace tsg::places::test {

/// What an ideal sensor saw of a world, as an extractor and as its layers.
struct SeenWorld {
  explicit SeenWorld(const BoxWorld& world, const Aabb& box,
                     const PlacesConfig& config = makeSparseConfig(),
                     const std::function<bool(const Eigen::Vector3d&)>& is_seen = {})
      : layers(config), extractor(config) {
    const auto blocks = observe(world, box, volume, is_seen);
    const auto changed = voxels.copyBlocks(volume, blocks);
    layers.update(voxels, {changed.begin(), changed.end()});
    extractor.update(volume, blocks, Stamp{1});
  }

  mapping::TsdfVolume volume{kVoxel_m};
  VoxelMap voxels;
  PlaceLayers layers;
  PlaceExtractor extractor;
};

/// All free cells of a space with their positions (of a plan: on the floor).
template <typename Visit>
void forEachFree(const SpaceMap& space, const std::vector<TileIndex>& tiles, Visit visit) {
  for (const TileIndex& index : tiles) {
    const SpaceTile* tile = space.find(index);
    if (tile == nullptr) continue;
    for (const SpaceCell& cell : tile->cells) {
      if (!cell.is_free) continue;
      const Column column = computeColumn(index, cell.offset);
      visit(cell, Eigen::Vector3d((column.x + 0.5) * space.voxelSize(),
                                  (column.y + 0.5) * space.voxelSize(),
                                  static_cast<double>(cell.level_m)));
    }
  }
}

/// A camera that moves in a straight line, a pose every 0.1 m and 0.1 s.
inline std::vector<CameraPose> walk(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                                    double start_s = 1.0) {
  std::vector<CameraPose> poses;
  const int steps = 1 + static_cast<int>((to - from).norm() / 0.1);
  for (int i = 0; i <= steps; ++i) {
    CameraPose pose;
    pose.stamp = Stamp::fromSeconds(start_s + 0.1 * i);
    pose.T_world_camera.translation() = from + (to - from) * (static_cast<double>(i) / steps);
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace tsg::places::test
