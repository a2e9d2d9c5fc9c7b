// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/loops/constellation.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "task_scene_graph/config/config.h"

namespace tsg::loops {
namespace {

constexpr std::size_t kMostPairs = 300;
constexpr double kLeastSpread_m = 0.3;  ///< across the line on which landmarks nearly lie

struct Pair {
  std::size_t a;
  std::size_t b;
  double cosine;
};

std::vector<Pair> listPairs(const std::vector<Landmark>& a, const std::vector<Landmark>& b,
                            double min_cosine) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) {
      if (a[i].embedding.size() != b[j].embedding.size()) continue;
      const double cosine = computeCosine(a[i].embedding, b[j].embedding);
      if (cosine >= min_cosine) pairs.push_back({i, j, cosine});
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& x, const Pair& y) { return x.cosine > y.cosine; });
  if (pairs.size() > kMostPairs) pairs.resize(kMostPairs);
  return pairs;
}

using Agreement = Eigen::Matrix<bool, Eigen::Dynamic, Eigen::Dynamic>;

Agreement computeAgreement(const std::vector<Landmark>& a, const std::vector<Landmark>& b,
                           const std::vector<Pair>& pairs, double tolerance_m) {
  const auto num = static_cast<Eigen::Index>(pairs.size());
  Agreement agrees = Agreement::Constant(num, num, false);
  for (Eigen::Index i = 0; i < num; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      const Pair& x = pairs[static_cast<std::size_t>(i)];
      const Pair& y = pairs[static_cast<std::size_t>(j)];
      if (x.a == y.a || x.b == y.b) continue;
      const double in_a = (a[x.a].position_m - a[y.a].position_m).norm();
      const double in_b = (b[x.b].position_m - b[y.b].position_m).norm();
      agrees(i, j) = agrees(j, i) = std::abs(in_a - in_b) <= tolerance_m;
    }
  }
  return agrees;
}

/// From one pair on: of those that agree with all so far the one that agrees with most.
std::vector<Eigen::Index> grow(const Agreement& agrees, const std::vector<Eigen::Index>& order,
                               Eigen::Index first) {
  std::vector<Eigen::Index> set = {first};
  for (const Eigen::Index next : order) {
    const bool fits = std::all_of(set.begin(), set.end(),
                                  [&](Eigen::Index member) { return agrees(member, next); });
    if (fits) set.push_back(next);
  }
  return set;
}

std::vector<Eigen::Index> findLargestSet(const Agreement& agrees) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(agrees.rows()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  const Eigen::VectorXi degree = agrees.cast<int>().rowwise().sum();
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index x, Eigen::Index y) { return degree(x) > degree(y); });
  std::vector<Eigen::Index> best;
  for (const Eigen::Index first : order) {
    if (degree(first) < static_cast<int>(best.size())) break;
    std::vector<Eigen::Index> set = grow(agrees, order, first);
    if (set.size() > best.size()) best = std::move(set);
  }
  return best;
}

/// Root mean square distance from the line that fits best.
double computeSpread(const Eigen::Matrix3Xd& points_m) {
  const Eigen::Vector3d middle_m = points_m.rowwise().mean();
  const Eigen::Matrix3Xd centered_m = points_m.colwise() - middle_m;
  const Eigen::Matrix3d scatter = centered_m * centered_m.transpose();
  const Eigen::Vector3d values = Eigen::JacobiSVD<Eigen::Matrix3d>(scatter).singularValues();
  return std::sqrt((values(1) + values(2)) / static_cast<double>(points_m.cols()));
}

}  // namespace

Constellation matchConstellation(const std::vector<Landmark>& a, const std::vector<Landmark>& b,
                                 const ConstellationConfig& config) {
  config::validate(config, "constellation");
  const std::vector<Pair> pairs = listPairs(a, b, config.min_cosine);
  const auto set = findLargestSet(computeAgreement(a, b, pairs, config.max_distance_error_m));
  if (set.size() < static_cast<std::size_t>(config.min_landmarks)) return {};
  Constellation result;
  Eigen::Matrix3Xd in_a(3, static_cast<Eigen::Index>(set.size()));
  Eigen::Matrix3Xd in_b = in_a;
  for (std::size_t k = 0; k < set.size(); ++k) {
    const Pair& pair = pairs[static_cast<std::size_t>(set[k])];
    result.pairs.emplace_back(pair.a, pair.b);
    in_a.col(static_cast<Eigen::Index>(k)) = a[pair.a].position_m;
    in_b.col(static_cast<Eigen::Index>(k)) = b[pair.b].position_m;
  }
  if (computeSpread(in_a) < kLeastSpread_m || computeSpread(in_b) < kLeastSpread_m) return {};
  result.T_a_b.matrix() = Eigen::umeyama(in_b, in_a, false);
  return result;
}

void joinLandmarks(const std::vector<Landmark>& more, double radius_m, double min_cosine,
                   std::vector<Landmark>& landmarks) {
  for (const Landmark& landmark : more) {
    const auto same = std::find_if(landmarks.begin(), landmarks.end(), [&](const Landmark& known) {
      return (known.position_m - landmark.position_m).norm() <= radius_m &&
             known.embedding.size() == landmark.embedding.size() &&
             computeCosine(known.embedding, landmark.embedding) >= min_cosine;
    });
    if (same == landmarks.end()) {
      landmarks.push_back(landmark);
    } else {
      same->position_m = 0.5 * (same->position_m + landmark.position_m);
    }
  }
}

}  // namespace tsg::loops
