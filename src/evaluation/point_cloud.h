// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace tsg::evaluation {

using PointCloud = std::vector<Eigen::Vector3f>;  ///< world frame, metres

/// Points by cubes of one size.
class PointGrid {
 public:
  PointGrid(const PointCloud& points_m, double cell_m);

  /// Calls `action(index)` for every point of the cloud nearer to `p` than the grid's cells are
  /// wide, until it returns false.
  template <typename Action>
  void forEachNear(const Eigen::Vector3f& p_m, const Action& action) const;

 private:
  using Cell = std::array<int, 3>;
  struct Hash {
    std::size_t operator()(const Cell& cell) const;
  };
  Cell findCell(const Eigen::Vector3f& p_m) const;

  const PointCloud& points_m_;
  float cell_m_;
  std::unordered_map<Cell, std::vector<std::size_t>, Hash> cells_;
};

template <typename Action>
void PointGrid::forEachNear(const Eigen::Vector3f& p_m, const Action& action) const {
  const Cell center = findCell(p_m);
  for (int i = 0; i < 27; ++i) {
    const auto found =
        cells_.find({center[0] + i % 3 - 1, center[1] + i / 3 % 3 - 1, center[2] + i / 9 - 1});
    if (found == cells_.end()) continue;
    for (const std::size_t index : found->second) {
      if ((points_m_[index] - p_m).squaredNorm() < cell_m_ * cell_m_ && !action(index)) return;
    }
  }
}

/// The mean of the points of each voxel, in an order that follows from the points alone.
PointCloud downsample(const PointCloud& points_m, double voxel_m);

/// Share of the points of `a` that have one of `b` nearer than `distance_m`; 0 for an empty cloud.
/// O(a * points of b in a cube of three distances).
double computeOverlap(const PointCloud& a, const PointCloud& b, double distance_m);

/// The largest cluster of DBSCAN (the first among equals): points with `min_points` or more nearer
/// than `radius_m`, themselves included, and what lies that near to them. All points where there is
/// no cluster, or the largest has fewer than 5.
PointCloud keepLargestCluster(const PointCloud& points_m, double radius_m, std::size_t min_points);

}  // namespace tsg::evaluation
