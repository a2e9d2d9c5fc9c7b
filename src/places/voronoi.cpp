// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "task_scene_graph/places/free_space.h"

namespace tsg::places {
namespace {

/// True if two neighbouring cells have nearest obstacles on different sides.
bool hasDistinctParents(const FreeSpace& space, std::size_t cell, std::size_t neighbour,
                        const PlacesConfig& config) {
  const std::int32_t parent = space.parent[cell];
  const std::int32_t other = space.parent[neighbour];
  if (parent == NearestField::kNone || other == NearestField::kNone || parent == other)
    return false;
  const GridIndex at = space.extent.toIndex(cell);
  const GridIndex to_parent = space.extent.toIndex(static_cast<std::size_t>(parent)) - at;
  const GridIndex to_other = space.extent.toIndex(static_cast<std::size_t>(other)) - at;
  const double separation_m = (to_parent - to_other).cwiseAbs().sum() * space.voxel_size_m;
  if (separation_m > config.min_parent_separation_m) return true;
  const double cosine =
      to_parent.cast<double>().normalized().dot(to_other.cast<double>().normalized());
  return cosine < config.max_parent_cosine;
}

}  // namespace

std::vector<char> findVoronoiCells(const FreeSpace& space, const PlacesConfig& config) {
  std::vector<char> is_voronoi(space.extent.numCells(), 0);
  const auto is_open = [&](std::size_t cell) {
    return space.is_free[cell] != 0 &&
           static_cast<double>(space.clearance_m[cell]) >= config.min_clearance_m;
  };
  for (std::size_t cell = 0; cell < is_voronoi.size(); ++cell) {
    if (!is_open(cell)) continue;
    const GridIndex index = space.extent.toIndex(cell);
    for (int axis = 0; axis < 3; ++axis) {
      const GridIndex next = index + GridIndex::Unit(axis);
      if (!space.extent.contains(next)) continue;
      const std::size_t neighbour = space.extent.toLinear(next);
      if (!is_open(neighbour) || !hasDistinctParents(space, cell, neighbour, config)) continue;
      is_voronoi[cell] = 1;
      is_voronoi[neighbour] = 1;
    }
  }
  return is_voronoi;
}

double computeLineClearance(const FreeSpace& space, std::size_t from, std::size_t to) {
  const Eigen::Vector3d start = space.extent.toIndex(from).cast<double>();
  const Eigen::Vector3d step = space.extent.toIndex(to).cast<double>() - start;
  const int samples = 2 * static_cast<int>(step.cwiseAbs().maxCoeff()) + 1;
  double smallest_m = static_cast<double>(space.clearance_m[from]);
  for (int i = 0; i <= samples; ++i) {
    const Eigen::Vector3d at = start + step * (static_cast<double>(i) / samples);
    const GridIndex index = (at.array() + 0.5).floor().cast<int>();
    const std::size_t cell = space.extent.toLinear(index);
    if (space.is_free[cell] == 0) return 0.0;
    smallest_m = std::min(smallest_m, static_cast<double>(space.clearance_m[cell]));
  }
  return smallest_m;
}

}  // namespace tsg::places
