// SPDX-License-Identifier: BSD-3-Clause
#include "robust_solver.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace tsg::trajectory {
namespace {

constexpr int kRoughIterations = 5;  ///< of a round that another one follows
constexpr double kRoughDecrease = 1e-3;
constexpr int kMaxRounds = 100;
constexpr double kRetriedShare = 10.0;  ///< of the chi2 that is still believed
constexpr int kMaxSettlings = 10;

Pose toPose(const SolverPose& pose) {
  Pose T = Pose::Identity();
  T.linear() = pose.rotation.toRotationMatrix();
  T.translation() = pose.position_m;
  return T;
}

/// [GNC20, Eq. 14]
double computeWeight(double chi2, double max_chi2, double mu) {
  if (chi2 >= (mu + 1.0) / mu * max_chi2) return 0.0;
  if (chi2 <= mu / (mu + 1.0) * max_chi2) return 1.0;
  return std::sqrt(max_chi2 * mu * (mu + 1.0) / chi2) - mu;
}

}  // namespace

double RobustSolver::computeChi2(const SolverEdge& edge) const {
  const Vector6d error =
      computeError(*edge.edge, config_, bias_, toPose(poses_[edge.a]), toPose(poses_[edge.b]));
  return error.dot(edge.edge->information * error);
}

bool RobustSolver::solveOnce(bool is_final, bool is_rough) {
  const SolverResult result =
      solvePoses(edges_, config_, is_rough ? kRoughIterations : config_.max_iterations,
                 is_rough ? kRoughDecrease : config_.min_relative_decrease, poses_, bias_);
  ++num_rounds_;
  has_converged_ = result.has_converged;
  num_iterations_ += result.num_iterations;
  if (result.is_usable && (result.has_converged || !is_final)) return true;
  status_ = result.is_usable ? SolveStatus::kNotConverged : SolveStatus::kFailed;
  std::ostringstream text;
  text << "the solver stopped after " << result.num_iterations << " iterations (max_iterations "
       << config_.max_iterations << "): " << result.message;
  message_ = text.str();
  return false;
}

bool RobustSolver::isConsistent() const {
  return std::all_of(edges_.begin() + static_cast<std::ptrdiff_t>(num_odometry_), edges_.end(),
                     [&](const SolverEdge& loop) {
                       return (loop.weight > 0.0) == (computeChi2(loop) <= config_.max_loop_chi2);
                     });
}

void RobustSolver::setWeights(double mu) {
  for (std::size_t i = num_odometry_; i < edges_.size(); ++i) {
    edges_[i].weight = computeWeight(computeChi2(edges_[i]), config_.max_loop_chi2, mu);
  }
}

bool RobustSolver::hasPartialWeight() const {
  return std::any_of(edges_.begin(), edges_.end(),
                     [](const SolverEdge& edge) { return edge.weight > 0.0 && edge.weight < 1.0; });
}

bool RobustSolver::graduate() {
  for (std::size_t i = num_odometry_; i < edges_.size(); ++i) edges_[i].weight = 1.0;
  if (!solveOnce(false, true)) return false;
  double worst = 0.0;
  for (std::size_t i = num_odometry_; i < edges_.size(); ++i) {
    worst = std::max(worst, computeChi2(edges_[i]));
  }
  const double max_chi2 = config_.max_loop_chi2;
  if (worst <= max_chi2) return true;
  double mu = max_chi2 / (2.0 * worst - max_chi2);  // [GNC20, Remark 5]
  for (int round = 0; round < kMaxRounds; ++round, mu *= config_.gnc_factor) {
    setWeights(mu);
    if (round > 0 && !hasPartialWeight()) return true;
    if (!solveOnce(false, true)) return false;
  }
  return true;
}

bool RobustSolver::settle() {
  for (int pass = 0; pass < kMaxSettlings; ++pass) {
    for (std::size_t i = num_odometry_; i < edges_.size(); ++i) {
      edges_[i].weight = computeChi2(edges_[i]) <= config_.max_loop_chi2 ? 1.0 : 0.0;
    }
    if (!solveOnce(true, false)) return false;
    if (isConsistent()) return true;
  }
  return true;
}

double RobustSolver::computeCost() const {
  double cost = 0.0;
  for (const SolverEdge& edge : edges_) {
    cost += edge.weight > 0.0 ? computeChi2(edge) : config_.max_loop_chi2;
  }
  return cost;
}

bool RobustSolver::retry() {
  const std::vector<SolverEdge> edges = edges_;
  const SolverPoses poses = poses_;
  const OdometryBias bias = bias_;
  const double cost = computeCost();
  for (SolverEdge& edge : edges_) {
    if (computeChi2(edge) <= kRetriedShare * config_.max_loop_chi2) edge.weight = 1.0;
  }
  if (!solveOnce(true, false) || !settle()) return false;
  if (computeCost() < cost) return true;
  edges_ = edges;
  poses_ = poses;
  bias_ = bias;
  return true;
}

bool RobustSolver::solve() {
  // Wrong loop closures may keep the plain solution from converging.
  if (!solveOnce(false, false)) return false;
  return (has_converged_ && isConsistent()) || (graduate() && settle() && retry());
}

const SolverEdge* RobustSolver::findWorstOdometry() const {
  const auto end = edges_.begin() + static_cast<std::ptrdiff_t>(num_odometry_);
  const auto worst = std::max_element(
      edges_.begin(), end,
      [&](const SolverEdge& x, const SolverEdge& y) { return computeChi2(x) < computeChi2(y); });
  return worst == end ? nullptr : &*worst;
}

}  // namespace tsg::trajectory
