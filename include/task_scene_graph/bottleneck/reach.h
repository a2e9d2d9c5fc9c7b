// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "task_scene_graph/core/box.h"

namespace tsg::bottleneck {

/// A box with every face moved out by a share of the box's middle side (of three): how far it
/// reaches for neighbours. Things that are large may lie farther apart and still be one: the seat
/// and the backrest of a chair, not two bottles on a shelf. 0: the box itself. Empty boxes stay so.
/// deviation: [Clio24, Sec. IV-B] joins primitives whose boxes overlap.
inline Aabb extendByReach(const Aabb& box, double reach) {
  if (box.isEmpty() || !(reach > 0.0)) return box;
  const Eigen::Vector3d size_m = box.sizes();
  const double middle_m =
      size_m.sum() - std::max({size_m.x(), size_m.y(), size_m.z()}) - size_m.minCoeff();
  const Eigen::Vector3d margin_m = Eigen::Vector3d::Constant(reach * middle_m);
  return makeAabb(box.min() - margin_m, box.max() + margin_m);
}

}  // namespace tsg::bottleneck
