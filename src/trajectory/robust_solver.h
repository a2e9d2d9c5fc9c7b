// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pose_graph_solver.h"

namespace tsg::trajectory {

/// Decides which loop closures of a graph can be true together, and solves it with these.
/// Graduated non-convexity with a truncated least squares cost [GNC20]; odometry is never doubted.
class RobustSolver {
 public:
  /// @param poses  from where to start
  RobustSolver(const PoseGraphConfig& config, std::vector<SolverEdge> odometry, SolverPoses poses,
               const OdometryBias& bias)
      : config_(config),
        edges_(std::move(odometry)),
        num_odometry_(edges_.size()),
        poses_(std::move(poses)),
        bias_(bias) {}

  /// A loop closure that takes part; weight 0: it was rejected before, and takes part only if the
  /// others turn out not to be right.
  void addLoop(const SolverEdge& loop) { edges_.push_back(loop); }

  /// False if the solver failed, see status() and message().
  bool solve();

  SolveStatus status() const { return status_; }
  const std::string& message() const { return message_; }
  int numRounds() const { return num_rounds_; }
  int numIterations() const { return num_iterations_; }
  const SolverPoses& poses() const { return poses_; }
  const OdometryBias& bias() const { return bias_; }
  /// Of a loop closure, in the order of adding.
  bool isBelieved(std::size_t loop) const { return edges_[num_odometry_ + loop].weight > 0.0; }
  std::size_t numLoops() const { return edges_.size() - num_odometry_; }
  double computeChi2(const SolverEdge& edge) const;
  /// The odometry edge that is bent most; null if there is none.
  const SolverEdge* findWorstOdometry() const;

 private:
  /// False with status and message if there is no solution, or a final one has not converged.
  bool solveOnce(bool is_final, bool is_rough);
  /// Whether exactly those loop closures have a weight that fit.
  bool isConsistent() const;
  void setWeights(double mu);
  bool hasPartialWeight() const;
  /// Weights between 0 and 1 become one or the other, until they do not change any more.
  bool settle();
  bool graduate();
  /// Lets those pull again that nearly fit: alone they may have been too far off, with their pull
  /// they may not be. The solution that costs less stays.
  bool retry();
  /// Truncated least squares: a loop closure that is left out costs max_loop_chi2.
  double computeCost() const;

  const PoseGraphConfig& config_;
  std::vector<SolverEdge> edges_;  ///< odometry first
  std::size_t num_odometry_;
  SolverPoses poses_;
  OdometryBias bias_;
  SolveStatus status_ = SolveStatus::kSolved;
  std::string message_;
  bool has_converged_ = false;  ///< of the newest solution
  int num_rounds_ = 0;
  int num_iterations_ = 0;
};

}  // namespace tsg::trajectory
