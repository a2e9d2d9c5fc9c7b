// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "task_scene_graph/core/primitives.h"

namespace tsg::scene_graph {

/// The floor around places.
struct Footprint {
  double area_m2 = 0.0;
  std::vector<Eigen::Vector2d> outline_m;  ///< of the largest part, counter-clockwise; may be empty
};

/// The union of the discs of the places' clearances, in cells of 0.1 m (coarser
/// where it is wider than 100 m): a cell counts if its centre is in a disc.
/// O(cells of the bounding rectangle).
Footprint computeFootprint(const std::vector<const Place*>& places);

}  // namespace tsg::scene_graph
