// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/bottleneck/relevance.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>

namespace tsg::bottleneck {
namespace {

constexpr int kTileWidth = 16;  // as many sums in registers as hide the latency of one
using Tile = Eigen::Array<double, kTileWidth, 1>;

// One accumulator per task, summed in order of dimension: no other task changes a task's score.
Tile computeTileProducts(const Embedding& embedding, const double* tile) {
  Tile sum = Tile::Zero();
  for (Eigen::Index d = 0; d < embedding.size(); ++d) {
    sum += static_cast<double>(embedding[d]) * Eigen::Map<const Tile>(tile + d * kTileWidth);
  }
  return sum;
}

std::vector<double> makeTheta(const std::vector<double>& scores, double alpha) {
  std::vector<double> theta{alpha};
  theta.reserve(scores.size() + 1);
  for (const double score : scores) theta.push_back(std::max(score, 0.0));
  return theta;
}

// Indices of the k largest, best first.
std::vector<std::uint32_t> rankBest(const std::vector<double>& theta, std::size_t k) {
  std::vector<std::uint32_t> order(theta.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto better = [&](std::uint32_t a, std::uint32_t b) {
    return theta[a] > theta[b] || (theta[a] == theta[b] && a < b);
  };
  const auto end = order.begin() + static_cast<std::ptrdiff_t>(k);
  std::partial_sort(order.begin(), end, order.end(), better);
  order.erase(end, order.end());
  return order;
}

}  // namespace

void checkEmbedding(const Eigen::Ref<const Embedding>& embedding, const std::string& whose) {
  const auto fail = [&](const char* what) {
    throw std::invalid_argument("the embedding of " + whose + " " + what +
                                "; expected a finite vector other than zero");
  };
  if (embedding.size() == 0) fail("is empty");
  if (!embedding.allFinite()) fail("has an entry that is not finite");
  if ((embedding.array() == 0.0f).all()) fail("is zero");
}

TaskScorer::TaskScorer(const EmbeddingMatrix& tasks)
    : num_tasks_(static_cast<int>(tasks.rows())),
      dimension_(tasks.rows() > 0 ? static_cast<int>(tasks.cols()) : 0) {
  const int num_tiles = (num_tasks_ + kTileWidth - 1) / kTileWidth;
  tiles_.assign(static_cast<std::size_t>(num_tiles * kTileWidth) * tasks.cols(), 0.0);
  for (int j = 0; j < num_tasks_; ++j) {
    checkEmbedding(tasks.row(j).transpose(), "task " + std::to_string(j));
    const Eigen::VectorXd unit = tasks.row(j).transpose().cast<double>().normalized();
    double* tile =
        tiles_.data() + static_cast<std::ptrdiff_t>(j / kTileWidth) * kTileWidth * dimension_;
    for (int d = 0; d < dimension_; ++d) tile[d * kTileWidth + j % kTileWidth] = unit[d];
  }
}

std::vector<double> TaskScorer::computeScores(const Embedding& embedding) const {
  std::vector<double> scores(static_cast<std::size_t>(num_tasks_));
  const double norm = embedding.cast<double>().norm();
  for (int first = 0; first < num_tasks_; first += kTileWidth) {
    const Tile products = computeTileProducts(
        embedding, tiles_.data() + static_cast<std::ptrdiff_t>(first) * dimension_);
    const int count = std::min(kTileWidth, num_tasks_ - first);
    for (int j = 0; j < count; ++j) {
      scores[static_cast<std::size_t>(first + j)] = std::clamp(products[j] / norm, -1.0, 1.0);
    }
  }
  return scores;
}

bool isPruned(const std::vector<double>& scores, const ClusteringConfig& config) {
  if (scores.empty()) return true;
  return config.prune_null && *std::max_element(scores.begin(), scores.end()) < config.alpha;
}

SparseMasses computeRelevance(const std::vector<double>& scores, const ClusteringConfig& config) {
  if (isPruned(scores, config)) return {{0, 1.0}};
  const std::vector<double> theta = makeTheta(scores, config.alpha);
  const std::size_t k = std::min(theta.size(), static_cast<std::size_t>(config.top_k));
  SparseMasses masses;
  std::size_t times = k;  // k - l + 1
  for (const std::uint32_t task : rankBest(theta, k)) {
    const double factor = config.cumulative ? static_cast<double>(times--) : 1.0;
    if (theta[task] > 0.0) masses.push_back({task, factor * theta[task]});
  }
  if (masses.empty()) return {{0, 1.0}};
  std::sort(masses.begin(), masses.end(), [](auto a, auto b) { return a.task < b.task; });
  return toDistribution(masses);  // Eq. 5
}

}  // namespace tsg::bottleneck
