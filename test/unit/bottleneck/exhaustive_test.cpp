// SPDX-License-Identifier: BSD-3-Clause
// All partitions of small graphs into connected clusters, as a bound of the information kept.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>

#include "clustering_fixtures.h"

namespace tsg::bottleneck {
namespace {

using Labels = std::vector<std::size_t>;  // by primitive: its cluster

// Calls `visit` with every partition once, clusters numbered by first appearance.
void forEachPartition(std::size_t count, const std::function<void(const Labels&)>& visit) {
  Labels labels(count, 0);
  const std::function<void(std::size_t, std::size_t)> assign = [&](std::size_t i,
                                                                   std::size_t used) {
    if (i == count) return visit(labels);
    for (labels[i] = 0; labels[i] <= used; ++labels[i]) {
      assign(i + 1, std::max(used, labels[i] + 1));
    }
  };
  assign(0, 0);
}

bool isConnected(const Labels& labels, const Eigen::MatrixXi& adjacency) {
  std::vector<bool> is_reached(labels.size(), false);
  std::size_t num_seeds = 0;
  for (std::size_t seed = 0; seed < labels.size(); ++seed) {
    if (is_reached[seed]) continue;
    ++num_seeds;
    is_reached[seed] = true;
    for (std::vector<std::size_t> open{seed}; !open.empty();) {
      const std::size_t node = open.back();
      open.pop_back();
      for (std::size_t other = 0; other < labels.size(); ++other) {
        const bool is_next =
            !is_reached[other] && labels[other] == labels[node] &&
            adjacency(static_cast<Eigen::Index>(node), static_cast<Eigen::Index>(other)) != 0;
        if (!is_next) continue;
        is_reached[other] = true;
        open.push_back(other);
      }
    }
  }
  return num_seeds == 1 + *std::max_element(labels.begin(), labels.end());
}

double computeKept(const Labels& labels, const Eigen::MatrixXd& p) {
  const auto count = static_cast<Eigen::Index>(*std::max_element(labels.begin(), labels.end())) + 1;
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(count);
  Eigen::MatrixXd mixed = Eigen::MatrixXd::Zero(p.rows(), count);
  for (std::size_t x = 0; x < labels.size(); ++x) {
    weights[static_cast<Eigen::Index>(labels[x])] += 1.0 / static_cast<double>(labels.size());
    mixed.col(static_cast<Eigen::Index>(labels[x])) += p.col(static_cast<Eigen::Index>(x));
  }
  for (Eigen::Index c = 0; c < count; ++c) mixed.col(c) /= mixed.col(c).sum();
  const double p_y = 1.0 / static_cast<double>(p.rows());
  return test::computeDenseInformation(weights, mixed, Eigen::VectorXd::Constant(p.rows(), p_y));
}

// By number of clusters: the largest information that any partition keeps.
std::map<std::size_t, double> findBestKept(const test::ReferenceScene& scene) {
  const Eigen::MatrixXd p = test::computeDenseRelevance(scene, {});
  const auto indexOf = [&](NodeKey key) {
    return std::distance(scene.primitives.begin(), scene.primitives.find(key));
  };
  Eigen::MatrixXi adjacency = Eigen::MatrixXi::Zero(p.cols(), p.cols());
  for (const auto& [a, b] : test::findOverlaps(scene)) {
    adjacency(indexOf(a), indexOf(b)) = adjacency(indexOf(b), indexOf(a)) = 1;
  }
  std::map<std::size_t, double> best;
  forEachPartition(static_cast<std::size_t>(p.cols()), [&](const Labels& labels) {
    if (!isConnected(labels, adjacency)) return;
    double& kept = best[1 + *std::max_element(labels.begin(), labels.end())];
    kept = std::max(kept, computeKept(labels, p));
  });
  return best;
}

class ExhaustiveSearch : public testing::TestWithParam<int> {};  // number of primitives

TEST_P(ExhaustiveSearch, BoundsTheInformationKeptAfterEveryMerge) {
  std::size_t num_merges = 0;
  double greedy = 0.0;
  double optimal = 0.0;
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    test::SceneOptions options;
    options.num_primitives = GetParam();
    options.mean_degree = seed % 2 == 0 ? 100.0 : 4.0;  // all adjacent, or some
    const auto scene = test::SceneGenerator(options, seed).makeScene();
    const std::map<std::size_t, double> best = findBestKept(scene);
    ClusteringConfig config;
    config.delta = 1.0;
    auto clustering = makeClustering(scene, config);
    double kept = clustering.information();
    std::size_t num_clusters = scene.primitives.size();
    EXPECT_NEAR(kept, best.at(num_clusters), 1e-9);
    for (const Merge& merge : clustering.mergeSequence()) {
      kept -= merge.d;
      ASSERT_LE(kept, best.at(--num_clusters) + 1e-8) << "seed " << seed;
      greedy += kept;
      optimal += best.at(num_clusters);
      ++num_merges;
    }
    EXPECT_EQ(num_clusters, best.begin()->first) << "the components cannot be merged further";
  }
  if (GetParam() > 1) {
    EXPECT_GT(num_merges, 10u);
  }
  EXPECT_GE(greedy, 0.95 * optimal);  // greedy, but not blind
}

INSTANTIATE_TEST_SUITE_P(Primitives, ExhaustiveSearch, testing::Range(1, 8));

}  // namespace
}  // namespace tsg::bottleneck
