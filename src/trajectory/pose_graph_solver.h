// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "task_scene_graph/trajectory/pose_graph.h"

namespace tsg::trajectory {

struct SolverPose {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  bool is_fixed = false;
};

/// An edge between poses by their index. Weight 0: it is left out.
struct SolverEdge {
  std::size_t a = 0;
  std::size_t b = 0;
  const PoseEdge* edge = nullptr;
  double weight = 1.0;
};

using SolverPoses = std::vector<SolverPose>;

struct SolverResult {
  bool is_usable = false;  ///< the poses are better than they were, or as good
  bool has_converged = false;
  int num_iterations = 0;
  std::string message;  ///< the solver's own
};

/// Minimises the weighted sum of squared errors with Levenberg-Marquardt and sparse Cholesky.
/// One thread: the same poses from run to run. The bias only where the configuration allows one.
SolverResult solvePoses(const std::vector<SolverEdge>& edges, const PoseGraphConfig& config,
                        int max_iterations, double min_relative_decrease, SolverPoses& poses,
                        OdometryBias& bias);

}  // namespace tsg::trajectory
