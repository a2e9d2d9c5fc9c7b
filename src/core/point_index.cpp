// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/point_index.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

namespace tsg {

PointIndex::PointIndex(std::vector<Eigen::Vector3d> points_m)
    : points_m_(std::move(points_m)), by_x_(points_m_.size()) {
  for (std::size_t i = 0; i < by_x_.size(); ++i) by_x_[i] = {points_m_[i].x(), i};
  std::sort(by_x_.begin(), by_x_.end());
}

std::size_t PointIndex::findNearest(const Eigen::Vector3d& query_m) const {
  std::pair<double, std::size_t> best{std::numeric_limits<double>::infinity(), points_m_.size()};
  // False where this point and all behind it are too far away in x alone.
  const auto visit = [&](std::size_t i) {
    const double along_x_m = points_m_[i].x() - query_m.x();
    if (along_x_m * along_x_m > best.first) return false;
    best = std::min(best, {(points_m_[i] - query_m).squaredNorm(), i});
    return true;
  };
  const auto middle =
      std::lower_bound(by_x_.begin(), by_x_.end(), std::make_pair(query_m.x(), std::size_t{0}));
  auto right = middle;
  auto left = std::make_reverse_iterator(middle);
  bool goes_right = true;
  bool goes_left = true;
  while (goes_right || goes_left) {
    goes_right = goes_right && right != by_x_.end() && visit((right++)->second);
    goes_left = goes_left && left != by_x_.rend() && visit((left++)->second);
  }
  return best.second;
}

}  // namespace tsg
