// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

namespace tsg {

/// Which of many points lies nearest to a given one, without looking at all of them.
class PointIndex {
 public:
  /// Points in metres, finite. O(n log n).
  explicit PointIndex(std::vector<Eigen::Vector3d> points_m);

  bool isEmpty() const { return points_m_.empty(); }

  /// Index of the nearest point, the smallest of several at the same distance. Walks along x from
  /// the query until what follows is farther away: O(n^(2/3)) for points spread evenly over a
  /// volume, O(n^(1/2)) over a floor, O(n) if all have the same x. There must be a point.
  std::size_t findNearest(const Eigen::Vector3d& query_m) const;

 private:
  std::vector<Eigen::Vector3d> points_m_;
  std::vector<std::pair<double, std::size_t>> by_x_;  ///< x and index, ascending
};

}  // namespace tsg
