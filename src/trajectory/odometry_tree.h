// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "pose_graph_solver.h"

namespace tsg::trajectory {

/// Where keyframes are by odometry alone, and how far that can have drifted, to first order.
class OdometryTree {
 public:
  /// From the first keyframe of each connected part breadth first. O(keyframes + edges).
  OdometryTree(const PoseGraphConfig& config, std::size_t num_keyframes,
               const std::vector<SolverEdge>& odometry);

  /// chi2 of a loop closure under the covariance of odometry from one end to the other, its bias,
  /// and its own; nothing if odometry does not join them. O(keyframes between both).
  std::optional<double> computeChi2(const SolverEdge& loop) const;

 private:
  struct Node {
    std::size_t root = 0;
    std::size_t parent = 0;
    std::size_t depth = 0;
    bool is_reached = false;
    Pose T_root_node = Pose::Identity();
    Matrix6d covariance = Matrix6d::Zero();  ///< of T_root_node, as a motion of the root's frame
    /// Of that motion by the bias, in units of its deviations.
    Eigen::Matrix<double, 6, 4> by_bias = Eigen::Matrix<double, 6, 4>::Zero();
  };

  void grow(std::size_t root, const std::vector<SolverEdge>& odometry,
            const std::vector<std::vector<std::size_t>>& edges_of);
  std::size_t findCommonAncestor(std::size_t a, std::size_t b) const;

  PoseGraphConfig config_;
  std::vector<Node> nodes_;
};

}  // namespace tsg::trajectory
