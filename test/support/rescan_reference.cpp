// SPDX-License-Identifier: BSD-3-Clause
#include "rescan_reference.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace tsg::test {
namespace {

using Index = Eigen::Index;
using Edge = std::pair<Index, Index>;
constexpr double kTiny = 1e-12;
constexpr Index kMaxAssignmentMatrix = 5000;

Eigen::MatrixXd computeRelevance(const std::vector<Embedding>& embeddings,
                                 const EmbeddingMatrix& tasks, double alpha) {
  const auto count = static_cast<Index>(embeddings.size());
  EmbeddingMatrix rows(count, tasks.cols());
  for (Index i = 0; i < count; ++i) {
    rows.row(i) = embeddings[static_cast<std::size_t>(i)].normalized().transpose();
  }
  Eigen::MatrixXd theta(tasks.rows() + 1, count);
  theta.row(0).setConstant(alpha);
  theta.bottomRows(tasks.rows()) = (tasks.rowwise().normalized() * rows.transpose()).cast<double>();
  Eigen::MatrixXd p = Eigen::MatrixXd::Constant(theta.rows(), count, kTiny);
  for (Index i = 0; i < count; ++i) {
    Index first = 0;
    theta.col(i).maxCoeff(&first);
    if (first == 0) {
      p(0, i) = 1.0;
      continue;
    }
    Eigen::VectorXd rest = theta.col(i);
    rest[first] = -1.0;
    Index second = 0;
    rest.maxCoeff(&second);
    p(first, i) = 2.0 * theta(first, i);
    p(second, i) = theta(second, i);
    p.col(i) /= p.col(i).sum();
  }
  return p;
}

double computeEntropy(const Eigen::VectorXd& p) {
  double bits = 0.0;
  for (Index i = 0; i < p.size(); ++i) {
    if (p[i] > 1e-9) bits -= p[i] * std::log2(p[i]);
  }
  return bits;
}

double computeWeight(const Eigen::VectorXd& p_z, const Eigen::MatrixXd& p_y_z, const Edge& edge) {
  const auto [a, b] = edge;
  const double mass = p_z[a] + p_z[b];
  const double share = p_z[a] / mass;
  const Eigen::VectorXd mixed = share * p_y_z.col(a) + (1.0 - share) * p_y_z.col(b);
  return mass * (computeEntropy(mixed) - share * computeEntropy(p_y_z.col(a)) -
                 (1.0 - share) * computeEntropy(p_y_z.col(b)));
}

// Two full matrices at every merge, as published: the argument's copy, and the joint distribution.
double computeInformation(const Eigen::VectorXd& p_z, Eigen::MatrixXd p_y_z) {
  const double p_y = 1.0 / static_cast<double>(p_y_z.rows());
  const Eigen::MatrixXd joint = p_y_z * p_z.asDiagonal();
  double bits = 0.0;
  for (Index z = 0; z < joint.cols(); ++z) {
    for (Index y = 0; y < joint.rows(); ++y) {
      if (joint(y, z) > 1e-9) bits += joint(y, z) * std::log2(p_y_z(y, z) / p_y);
    }
  }
  return bits;
}

std::map<Edge, double> findEdges(const std::vector<Aabb>& boxes, const Eigen::VectorXd& p_z,
                                 const Eigen::MatrixXd& p_y_z) {
  std::map<Edge, double> edges;
  for (std::size_t a = 0; a < boxes.size(); ++a) {
    for (std::size_t b = a + 1; b < boxes.size(); ++b) {
      if (!hasOverlap(boxes[a], boxes[b])) continue;
      const Edge edge(static_cast<Index>(a), static_cast<Index>(b));
      edges[edge] = computeWeight(p_z, p_y_z, edge);
    }
  }
  return edges;
}

void mergeEdge(const Edge& merged, std::map<Edge, double>& edges, Eigen::VectorXd& p_z,
               Eigen::MatrixXd& p_y_z) {
  const auto [a, b] = merged;
  const double mass = p_z[a] + p_z[b];
  const Eigen::VectorXd mixed = (p_z[a] * p_y_z.col(a) + p_z[b] * p_y_z.col(b)) / mass;
  p_y_z.col(a) = mixed;
  p_z[a] = mass;
  p_z[b] = 0.0;
  std::vector<Edge> touched;
  for (auto it = edges.begin(); it != edges.end();) {
    Edge edge = it->first;
    const bool is_touched =
        edge.first == a || edge.second == a || edge.first == b || edge.second == b;
    if (!is_touched) {
      ++it;
      continue;
    }
    if (edge.first == b) edge.first = a;
    if (edge.second == b) edge.second = a;
    if (edge.first != edge.second) touched.push_back(std::minmax(edge.first, edge.second));
    it = edges.erase(it);
  }
  for (const Edge& edge : touched) edges[edge] = computeWeight(p_z, p_y_z, edge);
}

}  // namespace

std::size_t clusterByRescanning(const std::vector<Embedding>& embeddings,
                                const std::vector<Aabb>& boxes, const EmbeddingMatrix& tasks,
                                double alpha) {
  const auto count = static_cast<Index>(embeddings.size());
  Eigen::MatrixXd p_y_z = computeRelevance(embeddings, tasks, alpha);
  Eigen::VectorXd p_z = Eigen::VectorXd::Constant(count, 1.0 / static_cast<double>(count));
  std::map<Edge, double> edges = findEdges(boxes, p_z, p_y_z);
  std::vector<Index> assignment(embeddings.size());
  for (std::size_t i = 0; i < assignment.size(); ++i) assignment[i] = static_cast<Index>(i);
  Eigen::MatrixXd p_z_x;  // too large for memory in large maps
  if (count <= kMaxAssignmentMatrix) p_z_x = Eigen::MatrixXd::Identity(count, count);
  double information = computeInformation(p_z, p_y_z);
  const double total = information;
  std::size_t num_merges = 0;
  while (!edges.empty()) {
    const auto best = std::min_element(
        edges.begin(), edges.end(),
        [](const auto& left, const auto& right) { return left.second < right.second; });
    const Edge merged = best->first;
    mergeEdge(merged, edges, p_z, p_y_z);
    for (Index& cluster : assignment) cluster = cluster == merged.second ? merged.first : cluster;
    if (p_z_x.size() > 0) {
      p_z_x.row(merged.first) += p_z_x.row(merged.second);
      p_z_x.row(merged.second).setZero();
    }
    const double remaining = computeInformation(p_z, p_y_z);
    const double delta = (information - remaining) / total;
    if (delta > 2.0) break;  // never: to the end of the tape
    information = remaining;
    ++num_merges;
  }
  return num_merges;
}

}  // namespace tsg::test
