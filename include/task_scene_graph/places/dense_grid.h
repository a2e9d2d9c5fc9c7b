// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "task_scene_graph/mapping/tsdf_volume.h"

namespace tsg::places {

using mapping::GridIndex;

/// A box of cells, x fastest; size z = 1 for a ground plan.
struct GridExtent {
  GridIndex min = GridIndex::Zero();
  GridIndex size = GridIndex::Zero();

  std::size_t numCells() const {
    return static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()) *
           static_cast<std::size_t>(size.z());
  }
  bool contains(const GridIndex& index) const {
    return ((index - min).array() >= 0).all() && ((index - min).array() < size.array()).all();
  }
  std::size_t toLinear(const GridIndex& index) const {
    const GridIndex local = index - min;
    return static_cast<std::size_t>(local.x()) +
           static_cast<std::size_t>(size.x()) *
               (static_cast<std::size_t>(local.y()) +
                static_cast<std::size_t>(size.y()) * static_cast<std::size_t>(local.z()));
  }
  GridIndex toIndex(std::size_t linear) const {
    const auto nx = static_cast<std::size_t>(size.x());
    const auto ny = static_cast<std::size_t>(size.y());
    return min + GridIndex(static_cast<int>(linear % nx), static_cast<int>(linear / nx % ny),
                           static_cast<int>(linear / (nx * ny)));
  }
};

/// For every cell the nearest source: exact Euclidean distance transform (Felzenszwalb and
/// Huttenlocher 2012), with the source itself.
struct NearestField {
  static constexpr std::int32_t kNone = -1;

  std::vector<std::int32_t> source;         ///< linear index of a nearest source, or kNone
  std::vector<std::int32_t> squared_cells;  ///< squared distance to it, in cells
};

/// Sources farther than `max_cells` are not given. `is_source` has one entry per cell. Equally near
/// sources: any, but always the same one. O(cells).
NearestField computeNearestField(const GridExtent& extent, const std::vector<char>& is_source,
                                 double max_cells);

}  // namespace tsg::places
