// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "task_scene_graph/core/box.h"

namespace tsg::bottleneck {

/// A box with its top and its bottom moved out by a share of the box's middle side (of three): how
/// far it reaches for neighbours. Parts of one thing that stand on each other are often apart, as
/// what joins them is thin or hidden: the seat of a chair and its base, the books of a stack. What
/// stands side by side with a gap is seldom one thing, so boxes do not reach there. Large things
/// may lie farther apart. 0: the box itself. Empty boxes stay so. World coordinates, z up.
/// deviation: [Clio24, Sec. IV-B] joins primitives whose boxes overlap.
inline Aabb extendUpAndDown(const Aabb& box, double reach) {
  if (box.isEmpty() || !(reach > 0.0)) return box;
  const Eigen::Vector3d size_m = box.sizes();
  const double middle_m =
      size_m.sum() - std::max({size_m.x(), size_m.y(), size_m.z()}) - size_m.minCoeff();
  const Eigen::Vector3d margin_m(0.0, 0.0, reach * middle_m);
  return makeAabb(box.min() - margin_m, box.max() + margin_m);
}

}  // namespace tsg::bottleneck
