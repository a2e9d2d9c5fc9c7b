// SPDX-License-Identifier: BSD-3-Clause
#include "pose_graph_solver.h"

#include <ceres/ceres.h>
#include <ceres/version.h>

#include <array>

#include "relative_pose_error.h"

namespace tsg::trajectory {
namespace {

// Ceres 2.1 brought manifolds, 2.2 took away what they replace.
#if CERES_VERSION_MAJOR > 2 || (CERES_VERSION_MAJOR == 2 && CERES_VERSION_MINOR >= 1)
void addRotation(ceres::Problem& problem, double* q) {
  problem.AddParameterBlock(q, 4, new ceres::EigenQuaternionManifold);
}
#else
void addRotation(ceres::Problem& problem, double* q) {
  problem.AddParameterBlock(q, 4, new ceres::EigenQuaternionParameterization);
}
#endif

void addPose(SolverPose& pose, ceres::Problem& problem) {
  double* p = pose.position_m.data();
  double* q = pose.rotation.coeffs().data();
  if (problem.HasParameterBlock(p)) return;
  problem.AddParameterBlock(p, 3);
  addRotation(problem, q);
  if (!pose.is_fixed) return;
  problem.SetParameterBlockConstant(p);
  problem.SetParameterBlockConstant(q);
}

void addEdge(const SolverEdge& edge, SolverPoses& poses, ceres::Problem& problem) {
  using Cost = ceres::AutoDiffCostFunction<RelativePoseError, 6, 3, 4, 3, 4>;
  SolverPose& a = poses[edge.a];
  SolverPose& b = poses[edge.b];
  addPose(a, problem);
  addPose(b, problem);
  problem.AddResidualBlock(
      new Cost(new RelativePoseError(edge.edge->T_a_b, edge.edge->information, edge.weight)),
      nullptr, a.position_m.data(), a.rotation.coeffs().data(), b.position_m.data(),
      b.rotation.coeffs().data());
}

/// The bias in units of its deviations: a deviation of 0 leaves it without influence.
using SolverBias = std::array<double, 4>;

double divide(double value, double deviation) { return deviation > 0.0 ? value / deviation : 0.0; }

SolverBias toUnits(const OdometryBias& bias, const PoseGraphConfig& config) {
  SolverBias units{divide(bias.scale, config.odometry_scale), 0.0, 0.0, 0.0};
  for (std::size_t i = 0; i < 3; ++i) {
    units[i + 1] =
        divide(bias.turn_rad_per_m(static_cast<Eigen::Index>(i)), config.odometry_turn_rad_per_m);
  }
  return units;
}

OdometryBias toBias(const SolverBias& units, const PoseGraphConfig& config) {
  return {config.odometry_scale * units[0],
          config.odometry_turn_rad_per_m * Eigen::Vector3d(units[1], units[2], units[3])};
}

void addBiasedEdge(const SolverEdge& edge, const PoseGraphConfig& config, SolverPoses& poses,
                   SolverBias& bias, ceres::Problem& problem) {
  using Cost = ceres::AutoDiffCostFunction<BiasedPoseError, 6, 3, 4, 3, 4, 4>;
  SolverPose& a = poses[edge.a];
  SolverPose& b = poses[edge.b];
  addPose(a, problem);
  addPose(b, problem);
  problem.AddResidualBlock(new Cost(new BiasedPoseError(*edge.edge, config, edge.weight)), nullptr,
                           a.position_m.data(), a.rotation.coeffs().data(), b.position_m.data(),
                           b.rotation.coeffs().data(), bias.data());
}

void addPrior(SolverBias& bias, ceres::Problem& problem) {
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<BiasPrior, 4, 4>(new BiasPrior), nullptr,
                           bias.data());
}

}  // namespace

SolverResult solvePoses(const std::vector<SolverEdge>& edges, const PoseGraphConfig& config,
                        int max_iterations, double min_relative_decrease, SolverPoses& poses,
                        OdometryBias& bias) {
  const bool is_biased = hasBias(config);
  SolverBias units = toUnits(bias, config);
  ceres::Problem problem;
  if (is_biased) addPrior(units, problem);
  for (const SolverEdge& edge : edges) {
    if (edge.weight == 0.0) continue;
    if (isBiased(*edge.edge, config)) {
      addBiasedEdge(edge, config, poses, units, problem);
    } else {
      addEdge(edge, poses, problem);
    }
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = max_iterations;
  options.function_tolerance = min_relative_decrease;
  options.gradient_tolerance = 1e-12;
  options.parameter_tolerance = 1e-12;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (is_biased) bias = toBias(units, config);
  return {summary.IsSolutionUsable(), summary.termination_type == ceres::CONVERGENCE,
          static_cast<int>(summary.iterations.size()), summary.message};
}

}  // namespace tsg::trajectory
