// SPDX-License-Identifier: BSD-3-Clause
#include "bottleneck_reference.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace tsg::test {
namespace {

using bottleneck::ClusteringConfig;
using bottleneck::NodeKey;

double xlogx(double x) { return x > 0.0 ? x * std::log2(x) : 0.0; }

// Eq. 5 as a sum of k vectors gamma_l.
Eigen::VectorXd makeRelevanceColumn(const Eigen::VectorXd& phi, const ClusteringConfig& config) {
  Eigen::VectorXd theta(phi.size() + 1);
  theta[0] = config.alpha;
  for (Eigen::Index j = 0; j < phi.size(); ++j) theta[j + 1] = std::max(phi[j], 0.0);
  Eigen::VectorXd column = Eigen::VectorXd::Zero(theta.size());
  const bool is_pruned = phi.size() == 0 || (config.prune_null && phi.maxCoeff() < config.alpha);
  std::vector<Eigen::Index> order(static_cast<std::size_t>(theta.size()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return theta[a] > theta[b]; });
  const int k = std::min(config.top_k, static_cast<int>(theta.size()));
  for (int l = config.cumulative ? 1 : k; l <= k; ++l) {
    for (int i = 0; i < l; ++i)
      column[order[static_cast<std::size_t>(i)]] += theta[order[static_cast<std::size_t>(i)]];
  }
  if (is_pruned || column.sum() == 0.0) return Eigen::VectorXd::Unit(theta.size(), 0);
  return column / column.sum();
}

struct DenseState {
  std::vector<NodeKey> keys;
  Eigen::VectorXd p_x;
  Eigen::MatrixXd p_y_given_x;
  Eigen::MatrixXi adjacency;
  std::vector<std::vector<NodeKey>> members;
};

double computeDistance(const DenseState& s, Eigen::Index i, Eigen::Index j) {
  const double mass = s.p_x[i] + s.p_x[j];
  Eigen::MatrixXd columns(s.p_y_given_x.rows(), 2);
  columns << s.p_y_given_x.col(i), s.p_y_given_x.col(j);
  if (columns.col(0) == columns.col(1)) return 0.0;
  return mass *
         computeDenseJensenShannon(columns, Eigen::Vector2d(s.p_x[i] / mass, s.p_x[j] / mass));
}

void mergeDense(DenseState& s, Eigen::Index a, Eigen::Index b) {
  const double mass = s.p_x[a] + s.p_x[b];
  const Eigen::VectorXd mixed =
      (s.p_x[a] * s.p_y_given_x.col(a) + s.p_x[b] * s.p_y_given_x.col(b)) / mass;
  s.p_y_given_x.col(a) = mixed;
  s.p_x[a] = mass;
  s.p_x[b] = 0.0;
  s.adjacency.col(a) = s.adjacency.col(a).cwiseMax(s.adjacency.col(b));
  s.adjacency.row(a) = s.adjacency.col(a).transpose();
  s.adjacency.col(b).setZero();
  s.adjacency.row(b).setZero();
  s.adjacency(a, a) = 0;
  auto& members = s.members[static_cast<std::size_t>(a)];
  auto& others = s.members[static_cast<std::size_t>(b)];
  members.insert(members.end(), others.begin(), others.end());
  std::sort(members.begin(), members.end());
  others.clear();
}

DenseState makeState(const ReferenceScene& scene, const std::vector<KeyPair>& edges,
                     const ClusteringConfig& config) {
  DenseState s;
  for (const auto& [key, primitive] : scene.primitives) {
    s.keys.push_back(key);
    s.members.push_back({key});
  }
  const auto n = static_cast<Eigen::Index>(s.keys.size());
  s.p_x = Eigen::VectorXd::Constant(n, 1.0 / static_cast<double>(n));
  s.p_y_given_x = computeDenseRelevance(scene, config);
  s.adjacency = Eigen::MatrixXi::Zero(n, n);
  const auto indexOf = [&](NodeKey key) {
    return std::lower_bound(s.keys.begin(), s.keys.end(), key) - s.keys.begin();
  };
  for (const auto& [a, b] : edges) {
    s.adjacency(indexOf(a), indexOf(b)) = s.adjacency(indexOf(b), indexOf(a)) = 1;
  }
  return s;
}

struct Best {
  double cost = std::numeric_limits<double>::infinity();  // N d, rounded to 9 decimals
  Eigen::Index a = -1;
  Eigen::Index b = -1;
};

// Ascending a, then b: the first of equal costs wins.
Best findBest(const DenseState& s) {
  Best best;
  const auto n = static_cast<Eigen::Index>(s.keys.size());
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index b = a + 1; b < n; ++b) {
      if (s.adjacency(a, b) == 0) continue;
      const double cost = std::round(computeDistance(s, a, b) * static_cast<double>(n) * 1e9) / 1e9;
      if (cost < best.cost) best = {cost, a, b};
    }
  }
  return best;
}

bool isAccepted(const ClusteringConfig& config, double delta) {
  const double threshold = config.threshold();
  return threshold >= 1.0 || (threshold > 0.0 && delta < threshold);
}

}  // namespace

std::vector<KeyPair> findOverlaps(const ReferenceScene& scene) {
  std::vector<KeyPair> pairs;
  for (auto a = scene.primitives.begin(); a != scene.primitives.end(); ++a) {
    for (auto b = std::next(a); b != scene.primitives.end(); ++b) {
      bool is_overlapping = true;
      for (int axis = 0; axis < 3; ++axis) {
        is_overlapping &= a->second.box.min()[axis] < b->second.box.max()[axis] &&
                          b->second.box.min()[axis] < a->second.box.max()[axis];
      }
      if (is_overlapping) pairs.emplace_back(a->first, b->first);
    }
  }
  return pairs;
}

Eigen::MatrixXd computeDenseRelevance(const ReferenceScene& scene, const ClusteringConfig& config) {
  Eigen::MatrixXd relevance(scene.tasks.rows() + 1,
                            static_cast<Eigen::Index>(scene.primitives.size()));
  Eigen::Index column = 0;
  for (const auto& [key, primitive] : scene.primitives) {
    const Eigen::VectorXd x = primitive.embedding.cast<double>();
    Eigen::VectorXd phi(scene.tasks.rows());
    for (Eigen::Index j = 0; j < phi.size(); ++j) {
      const Eigen::VectorXd t = scene.tasks.row(j).transpose().cast<double>();
      phi[j] = x.dot(t) / (x.norm() * t.norm());
    }
    relevance.col(column++) = makeRelevanceColumn(phi, config);
  }
  return relevance;
}

double computeDenseEntropy(const Eigen::VectorXd& p) {
  return -p.unaryExpr([](double x) { return xlogx(x); }).sum();
}

double computeDenseInformation(const Eigen::VectorXd& p_x, const Eigen::MatrixXd& p_y_given_x,
                               const Eigen::VectorXd& p_y) {
  double bits = 0.0;
  for (Eigen::Index x = 0; x < p_x.size(); ++x) {
    for (Eigen::Index y = 0; y < p_y.size(); ++y) {
      const double p = p_y_given_x(y, x);
      if (p_x[x] > 0.0 && p > 0.0) bits += p_x[x] * p * std::log2(p / p_y[y]);
    }
  }
  return bits;
}

double computeDenseJensenShannon(const Eigen::MatrixXd& columns, const Eigen::VectorXd& weights) {
  double bits = computeDenseEntropy(columns * weights);
  for (Eigen::Index i = 0; i < columns.cols(); ++i) {
    bits -= weights[i] * computeDenseEntropy(columns.col(i));
  }
  return bits;
}

ReferenceResult clusterDense(const ReferenceScene& scene, const std::vector<KeyPair>& edges,
                             const ClusteringConfig& config) {
  ReferenceResult result;
  if (scene.primitives.empty()) return result;
  DenseState s = makeState(scene, edges, config);
  const Eigen::Index num_y = s.p_y_given_x.rows();
  const Eigen::VectorXd p_y =
      config.prior == bottleneck::Prior::kMarginal
          ? Eigen::VectorXd(s.p_y_given_x * s.p_x)
          : Eigen::VectorXd::Constant(num_y, 1.0 / static_cast<double>(num_y));
  const double n = static_cast<double>(s.keys.size());
  result.information = computeDenseInformation(s.p_x, s.p_y_given_x, p_y);
  double information = result.information;
  for (Best best = findBest(s); best.a >= 0; best = findBest(s)) {
    const double scale =
        config.normaliser == bottleneck::Normaliser::kPaper ? n * result.information : 2.0;
    const double delta = best.cost == 0.0 ? 0.0 : best.cost / scale;
    if (!isAccepted(config, delta)) break;
    result.merges.push_back({s.keys[static_cast<std::size_t>(best.a)],
                             s.keys[static_cast<std::size_t>(best.b)], best.cost / n, delta});
    mergeDense(s, best.a, best.b);
    const double remaining = computeDenseInformation(s.p_x, s.p_y_given_x, p_y);
    result.losses.push_back(information - remaining);
    information = remaining;
  }
  for (const auto& members : s.members) {
    if (!members.empty()) result.clusters.push_back(members);
  }
  return result;
}

SceneGenerator::SceneGenerator(const SceneOptions& options, std::uint32_t seed)
    : options_(options), random_(seed), tasks_(makeTasks()) {}

int SceneGenerator::uniformInt(int min, int max) {
  return std::uniform_int_distribution<int>(min, max)(random_);
}

double SceneGenerator::uniform(double min, double max) {
  return std::uniform_real_distribution<double>(min, max)(random_);
}

Embedding SceneGenerator::makeNoise() {
  std::normal_distribution<float> normal;
  Embedding noise(options_.dimension);
  for (Eigen::Index i = 0; i < noise.size(); ++i) noise[i] = normal(random_);
  return noise / noise.norm();
}

EmbeddingMatrix SceneGenerator::makeTasks() {
  EmbeddingMatrix tasks(options_.num_tasks, options_.dimension);
  for (int j = 0; j < options_.num_tasks; ++j) tasks.row(j) = makeNoise().transpose();
  return tasks;
}

Embedding SceneGenerator::makeEmbedding() {
  if (!earlier_.empty() && uniform(0, 1) < options_.duplicate_share) {
    return earlier_[static_cast<std::size_t>(uniformInt(0, static_cast<int>(earlier_.size()) - 1))];
  }
  Embedding embedding = makeNoise();
  if (options_.num_tasks > 0 && uniform(0, 1) >= options_.irrelevant_share) {
    for (int i = 0; i < 2; ++i) {
      const auto share = static_cast<float>(uniform(0.1, 0.6));
      embedding += share * tasks_.row(uniformInt(0, options_.num_tasks - 1)).transpose();
    }
  }
  earlier_.push_back(embedding);
  return embedding;
}

// Cubes of 1 m in a cube in which each meets mean_degree others: n 2^3 / side^3.
Aabb SceneGenerator::makeBox() {
  const double side = std::cbrt(options_.num_primitives * 8.0 / options_.mean_degree);
  const Eigen::Vector3d min(uniform(0, side), uniform(0, side), uniform(0, side));
  return makeAabb(min, min + Eigen::Vector3d::Ones());
}

ReferencePrimitive SceneGenerator::makePrimitive() { return {makeEmbedding(), makeBox()}; }

ReferenceScene SceneGenerator::makeScene() {
  ReferenceScene scene;
  scene.tasks = tasks_;
  while (static_cast<int>(scene.primitives.size()) < options_.num_primitives) {
    const auto key = static_cast<bottleneck::NodeKey>(uniformInt(1, 1000000));
    scene.primitives.emplace(key, makePrimitive());
  }
  return scene;
}

}  // namespace tsg::test
