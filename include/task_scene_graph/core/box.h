// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

namespace tsg {

/// Axis-aligned box in the world frame, metres. A default-constructed box is empty.
using Aabb = Eigen::AlignedBox3d;

inline Aabb makeAabb(const Eigen::Vector3d& min_m, const Eigen::Vector3d& max_m) {
  return Aabb(min_m, max_m);
}

/// True if the boxes share a volume; boxes that only touch do not overlap (strict inequality).
inline bool hasOverlap(const Aabb& a, const Aabb& b) {
  return (a.min().array() < b.max().array()).all() && (b.min().array() < a.max().array()).all();
}

/// Volume in cubic metres; 0 for an empty box.
inline double computeVolume(const Aabb& box) { return box.isEmpty() ? 0.0 : box.volume(); }

/// Volume of the intersection over volume of the union, in [0, 1]; 0 if both are flat or empty.
inline double computeIoU(const Aabb& a, const Aabb& b) {
  const double shared = hasOverlap(a, b) ? computeVolume(a.intersection(b)) : 0.0;
  const double total = computeVolume(a) + computeVolume(b) - shared;
  return total > 0.0 ? shared / total : 0.0;
}

}  // namespace tsg
