// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/places/near_pairs.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace tsg::places {

std::vector<NearPair> findNearPairs(const std::vector<Eigen::Vector3d>& from_m,
                                    const std::vector<Eigen::Vector3d>& to_m,
                                    double max_distance_m) {
  std::vector<std::size_t> by_x(to_m.size());
  std::iota(by_x.begin(), by_x.end(), 0U);
  std::sort(by_x.begin(), by_x.end(),
            [&](std::size_t a, std::size_t b) { return to_m[a].x() < to_m[b].x(); });
  std::vector<NearPair> pairs;
  for (std::size_t a = 0; a < from_m.size(); ++a) {
    const double min_x_m = from_m[a].x() - max_distance_m;
    auto it = std::lower_bound(by_x.begin(), by_x.end(), min_x_m,
                               [&](std::size_t b, double x_m) { return to_m[b].x() < x_m; });
    for (; it != by_x.end() && to_m[*it].x() <= from_m[a].x() + max_distance_m; ++it) {
      const double distance_m = (to_m[*it] - from_m[a]).norm();
      if (distance_m <= max_distance_m) pairs.push_back({a, *it, distance_m});
    }
  }
  std::sort(pairs.begin(), pairs.end(), [](const NearPair& left, const NearPair& right) {
    return std::tie(left.distance_m, left.a, left.b) < std::tie(right.distance_m, right.a, right.b);
  });
  return pairs;
}

}  // namespace tsg::places
