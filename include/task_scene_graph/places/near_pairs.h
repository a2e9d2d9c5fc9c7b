// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace tsg::places {

struct NearPair {
  std::size_t a = 0;
  std::size_t b = 0;
  double distance_m = 0.0;
};

/// All pairs (a of `from`, b of `to`) at most `max_distance_m` apart, by distance, then a, then b.
/// O(n log n + pairs whose x differ by at most max_distance_m).
std::vector<NearPair> findNearPairs(const std::vector<Eigen::Vector3d>& from_m,
                                    const std::vector<Eigen::Vector3d>& to_m,
                                    double max_distance_m);

}  // namespace tsg::places
