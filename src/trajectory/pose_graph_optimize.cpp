// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <numeric>
#include <sstream>

#include "odometry_tree.h"
#include "robust_solver.h"
#include "task_scene_graph/trajectory/pose_graph.h"

namespace tsg::trajectory {
namespace {

/// Fixes the first pose of each part that the edges join.
void fixFirstPoses(const std::vector<SolverEdge>& edges, SolverPoses& poses) {
  std::vector<std::size_t> parent(poses.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto rootOf = [&](std::size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const SolverEdge& edge : edges) {
    const std::size_t a = rootOf(edge.a);
    const std::size_t b = rootOf(edge.b);
    parent[std::max(a, b)] = std::min(a, b);
  }
  for (std::size_t i = 0; i < poses.size(); ++i) poses[i].is_fixed = parent[i] == i;
}

SolverPoses toSolverPoses(const std::vector<GraphKeyframe>& keyframes,
                          const std::vector<SolverEdge>& edges) {
  SolverPoses poses;
  for (const GraphKeyframe& keyframe : keyframes) {
    poses.push_back({keyframe.T_world_keyframe.translation(),
                     Eigen::Quaterniond(keyframe.T_world_keyframe.linear()), false});
  }
  fixFirstPoses(edges, poses);
  return poses;
}

void movePoses(const SolverPoses& solved, std::vector<GraphKeyframe>& keyframes) {
  for (std::size_t i = 0; i < solved.size(); ++i) {
    if (solved[i].is_fixed) continue;
    keyframes[i].T_world_keyframe.linear() = solved[i].rotation.normalized().toRotationMatrix();
    keyframes[i].T_world_keyframe.translation() = solved[i].position_m;
  }
}

/// A solver with all odometry and the loop closures that odometry allows.
/// @param verdicts  of all edges as they were; those that odometry contradicts are written
RobustSolver makeSolver(const PoseGraphConfig& config, const std::vector<SolverEdge>& edges,
                        const SolverPoses& poses, const OdometryBias& bias,
                        std::vector<Verdict>& verdicts) {
  std::vector<SolverEdge> odometry;
  std::copy_if(edges.begin(), edges.end(), std::back_inserter(odometry),
               [](const auto& edge) { return edge.edge->kind == EdgeKind::kOdometry; });
  const OdometryTree tree(config, poses.size(), odometry);
  RobustSolver solver(config, std::move(odometry), poses, bias);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (edges[i].edge->kind == EdgeKind::kOdometry) continue;
    if (tree.computeChi2(edges[i]).value_or(0.0) > config.max_gate_chi2) {
      verdicts[i] = Verdict::kOdometryContradicts;
      continue;
    }
    SolverEdge loop = edges[i];
    loop.weight = verdicts[i] == Verdict::kOtherEdgesContradict ? 0.0 : 1.0;
    solver.addLoop(loop);
    verdicts[i] = Verdict::kUndecided;
  }
  return solver;
}

/// @param verdicts  as makeSolver() left them
void decide(const RobustSolver& solver, const std::vector<PoseEdge>& edges,
            std::vector<Verdict>& verdicts) {
  std::size_t loop = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (edges[i].kind == EdgeKind::kOdometry) {
      verdicts[i] = Verdict::kBelieved;
    } else if (verdicts[i] != Verdict::kOdometryContradicts) {
      verdicts[i] = solver.isBelieved(loop++) ? Verdict::kBelieved : Verdict::kOtherEdgesContradict;
    }
  }
}

/// A fault if the solution bends an odometry edge too far.
void checkOdometry(const RobustSolver& solver, double limit, SolveReport& report) {
  const SolverEdge* worst = solver.findWorstOdometry();
  const double chi2 = worst == nullptr ? 0.0 : solver.computeChi2(*worst);
  if (chi2 <= limit) return;
  std::ostringstream text;
  text << "the solution bends odometry from keyframe " << worst->edge->a.value << " to "
       << worst->edge->b.value << " by a chi2 of " << chi2 << ", expected at most " << limit
       << " (max_odometry_chi2)";
  report.status = SolveStatus::kContradiction;
  report.message = text.str();
}

/// Whether the same edges make up the solution as before.
bool isSameSolution(const std::vector<Verdict>& before, const std::vector<Verdict>& after) {
  return std::equal(before.begin(), before.end(), after.begin(), [](Verdict a, Verdict b) {
    return (a == Verdict::kBelieved) == (b == Verdict::kBelieved);
  });
}

int countLoops(const std::vector<PoseEdge>& edges, const std::vector<Verdict>& verdicts,
               bool are_believed) {
  int count = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const bool is_believed = verdicts[i] == Verdict::kBelieved;
    if (edges[i].kind == EdgeKind::kLoop && is_believed == are_believed) ++count;
  }
  return count;
}

}  // namespace

SolveReport PoseGraph::optimize() {
  SolveReport report;
  if (std::count(verdicts_.begin(), verdicts_.end(), Verdict::kUndecided) == 0) return report;
  std::vector<SolverEdge> edges;
  for (const PoseEdge& edge : edges_) {
    edges.push_back({indexOf(edge.a), indexOf(edge.b), &edge, 1.0});
  }
  std::vector<Verdict> verdicts = verdicts_;
  RobustSolver solver =
      makeSolver(config_, edges, toSolverPoses(keyframes_, edges), bias_, verdicts);
  solver.solve();
  report.status = solver.status();
  report.message = solver.message();
  report.num_rounds = solver.numRounds();
  report.num_iterations = solver.numIterations();
  if (!report.isFault()) checkOdometry(solver, config_.max_odometry_chi2, report);
  if (report.isFault()) return report;
  decide(solver, edges_, verdicts);
  const bool is_same = isSameSolution(verdicts_, verdicts);
  verdicts_ = std::move(verdicts);
  report.chi2_before = computeChi2();
  if (is_same) {
    report.status = SolveStatus::kUnchanged;
  } else {
    movePoses(solver.poses(), keyframes_);
    bias_ = solver.bias();
  }
  report.chi2_after = computeChi2();
  report.num_believed = countLoops(edges_, verdicts_, true);
  report.num_rejected = countLoops(edges_, verdicts_, false);
  return report;
}

}  // namespace tsg::trajectory
