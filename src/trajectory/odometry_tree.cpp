// SPDX-License-Identifier: BSD-3-Clause
#include "odometry_tree.h"

#include <queue>

namespace tsg::trajectory {
namespace {

Matrix6d move(const Matrix6d& covariance, const Pose& T) {
  const Matrix6d adjoint = computeAdjoint(T);
  return adjoint * covariance * adjoint.transpose();
}

}  // namespace

OdometryTree::OdometryTree(const PoseGraphConfig& config, std::size_t num_keyframes,
                           const std::vector<SolverEdge>& odometry)
    : config_(config), nodes_(num_keyframes) {
  std::vector<std::vector<std::size_t>> edges_of(num_keyframes);
  for (std::size_t i = 0; i < odometry.size(); ++i) {
    edges_of[odometry[i].a].push_back(i);
    edges_of[odometry[i].b].push_back(i);
  }
  for (std::size_t root = 0; root < num_keyframes; ++root) {
    if (!nodes_[root].is_reached) grow(root, odometry, edges_of);
  }
}

void OdometryTree::grow(std::size_t root, const std::vector<SolverEdge>& odometry,
                        const std::vector<std::vector<std::size_t>>& edges_of) {
  nodes_[root].root = nodes_[root].parent = root;
  nodes_[root].is_reached = true;
  std::queue<std::size_t> queue({root});
  for (; !queue.empty(); queue.pop()) {
    const std::size_t parent = queue.front();
    for (const std::size_t i : edges_of[parent]) {
      const SolverEdge& edge = odometry[i];
      const bool leads_forward = edge.a == parent;
      const std::size_t child = leads_forward ? edge.b : edge.a;
      Node& node = nodes_[child];
      if (node.is_reached) continue;
      const Pose& T_a_b = edge.edge->T_a_b;
      node = {root,
              parent,
              nodes_[parent].depth + 1,
              true,
              nodes_[parent].T_root_node * (leads_forward ? T_a_b : T_a_b.inverse()),
              nodes_[parent].covariance,
              nodes_[parent].by_bias};
      // The error is a motion of b's frame whichever way the edge is gone.
      const Pose& T_root_b = (leads_forward ? node : nodes_[parent]).T_root_node;
      node.covariance += move(edge.edge->information.inverse(), T_root_b);
      const Eigen::Matrix<double, 6, 4> by_bias =
          computeAdjoint(T_root_b) * computeBiasJacobian(T_a_b, config_);
      node.by_bias += leads_forward ? by_bias : Eigen::Matrix<double, 6, 4>(-by_bias);
      queue.push(child);
    }
  }
}

std::size_t OdometryTree::findCommonAncestor(std::size_t a, std::size_t b) const {
  while (a != b) {
    std::size_t& deeper = nodes_[a].depth > nodes_[b].depth ? a : b;
    deeper = nodes_[deeper].parent;
  }
  return a;
}

std::optional<double> OdometryTree::computeChi2(const SolverEdge& loop) const {
  const Node& a = nodes_[loop.a];
  const Node& b = nodes_[loop.b];
  if (a.root != b.root) return std::nullopt;
  const Node& shared = nodes_[findCommonAncestor(loop.a, loop.b)];
  const Eigen::Matrix<double, 6, 4> by_bias = b.by_bias - a.by_bias;
  const Matrix6d way =
      a.covariance + b.covariance - 2.0 * shared.covariance + by_bias * by_bias.transpose();
  const Matrix6d covariance = move(way, b.T_root_node.inverse()) + loop.edge->information.inverse();
  const Vector6d error = computeError(*loop.edge, a.T_root_node, b.T_root_node);
  return error.dot(covariance.ldlt().solve(error));
}

}  // namespace tsg::trajectory
