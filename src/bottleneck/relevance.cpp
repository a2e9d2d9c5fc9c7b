// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/bottleneck/relevance.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "task_scene_graph/core/vectorize.h"

namespace tsg::bottleneck {
namespace {

// Four doubles that the compiler maps to whatever registers there are (GCC and Clang).
typedef double Lanes __attribute__((vector_size(32), aligned(8), may_alias));
typedef float FloatLanes __attribute__((vector_size(16), aligned(4), may_alias));
constexpr int kTileWidth = 16;        // four of them
constexpr Eigen::Index kChunk = 128;  // dimensions; that much of a tile fits the innermost cache

// Sums of two embeddings; of one alone, each addition would wait for the one before. One sum per
// task, in order of dimension: no other task or embedding changes a score.
TSG_VECTORIZE void addTileProducts(const float* a, const float* b, Eigen::Index dimension,
                                   const double* tile, double* sums_a, double* sums_b) {
  Lanes* out_a = reinterpret_cast<Lanes*>(sums_a);
  Lanes* out_b = reinterpret_cast<Lanes*>(sums_b);
  Lanes a0 = out_a[0], a1 = out_a[1], a2 = out_a[2], a3 = out_a[3];
  Lanes b0 = out_b[0], b1 = out_b[1], b2 = out_b[2], b3 = out_b[3];
  for (Eigen::Index d = 0; d < dimension; ++d, tile += kTileWidth) {
    const double x = static_cast<double>(a[d]);
    const double z = static_cast<double>(b[d]);
    const Lanes* row = reinterpret_cast<const Lanes*>(tile);
    a0 += x * row[0];
    b0 += z * row[0];
    a1 += x * row[1];
    b1 += z * row[1];
    a2 += x * row[2];
    b2 += z * row[2];
    a3 += x * row[3];
    b3 += z * row[3];
  }
  out_a[0] = a0, out_a[1] = a1, out_a[2] = a2, out_a[3] = a3;
  out_b[0] = b0, out_b[1] = b1, out_b[2] = b2, out_b[3] = b3;
}

TSG_VECTORIZE double computeSquaredNorm(const float* x, Eigen::Index dimension) {
  Lanes s0{}, s1{};
  Eigen::Index d = 0;
  for (; d + 8 <= dimension; d += 8) {
    const Lanes a = __builtin_convertvector(*reinterpret_cast<const FloatLanes*>(x + d), Lanes);
    const Lanes b = __builtin_convertvector(*reinterpret_cast<const FloatLanes*>(x + d + 4), Lanes);
    s0 += a * a;
    s1 += b * b;
  }
  const Lanes s = s0 + s1;
  double sum = (s[0] + s[1]) + (s[2] + s[3]);
  for (; d < dimension; ++d) sum += static_cast<double>(x[d]) * static_cast<double>(x[d]);
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
  const double squared_norm = computeSquaredNorm(embedding.data(), embedding.size());
  if (std::isfinite(squared_norm) && squared_norm > 0.0) return;
  const auto fail = [&](const char* what) {
    throw std::invalid_argument("the embedding of " + whose + " " + what +
                                "; expected a finite vector other than zero");
  };
  if (embedding.size() == 0) fail("is empty");
  if (!embedding.allFinite()) fail("has an entry that is not finite");
  fail("is zero");
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
  return computeScores(std::vector<const Embedding*>{&embedding}).front();
}

std::vector<std::vector<double>> TaskScorer::computeScores(
    const std::vector<const Embedding*>& embeddings) const {
  const std::vector<double> zeros(static_cast<std::size_t>(num_tasks_), 0.0);
  std::vector<std::vector<double>> scores(embeddings.size(), zeros);
  std::vector<double> sums((embeddings.size() + 1) * kTileWidth);  // of pairs
  for (int first = 0; first < num_tasks_; first += kTileWidth) {
    const double* tile = tiles_.data() + static_cast<std::ptrdiff_t>(first) * dimension_;
    std::fill(sums.begin(), sums.end(), 0.0);
    for (Eigen::Index d = 0; d < dimension_; d += kChunk) {
      const Eigen::Index length = std::min<Eigen::Index>(kChunk, dimension_ - d);
      for (std::size_t i = 0; i < embeddings.size(); i += 2) {
        const Embedding& last = *embeddings[std::min(i + 1, embeddings.size() - 1)];
        addTileProducts(embeddings[i]->data() + d, last.data() + d, length, tile + d * kTileWidth,
                        &sums[i * kTileWidth], &sums[(i + 1) * kTileWidth]);
      }
    }
    const auto count = static_cast<std::size_t>(std::min(kTileWidth, num_tasks_ - first));
    for (std::size_t i = 0; i < embeddings.size(); ++i) {
      std::copy_n(&sums[i * kTileWidth], count, scores[i].begin() + first);
    }
  }
  for (std::size_t i = 0; i < embeddings.size(); ++i) {
    const double norm = std::sqrt(computeSquaredNorm(embeddings[i]->data(), embeddings[i]->size()));
    for (double& score : scores[i]) score = std::clamp(score / norm, -1.0, 1.0);
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
