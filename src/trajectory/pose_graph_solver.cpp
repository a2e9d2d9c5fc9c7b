// SPDX-License-Identifier: BSD-3-Clause
#include "pose_graph_solver.h"

#include <ceres/ceres.h>
#include <ceres/version.h>

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

}  // namespace

SolverResult solvePoses(const std::vector<SolverEdge>& edges, int max_iterations,
                        double min_relative_decrease, SolverPoses& poses) {
  ceres::Problem problem;
  for (const SolverEdge& edge : edges) {
    if (edge.weight > 0.0) addEdge(edge, poses, problem);
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
  return {summary.IsSolutionUsable(), summary.termination_type == ceres::CONVERGENCE,
          static_cast<int>(summary.iterations.size()), summary.message};
}

}  // namespace tsg::trajectory
