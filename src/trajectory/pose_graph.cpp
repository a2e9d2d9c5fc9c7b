// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/trajectory/pose_graph.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/core/find_by_id.h"

namespace tsg::trajectory {
namespace {

const Eigen::IOFormat kOneLine(6, Eigen::DontAlignCols, " ", ", ", "", "", "[", "]");

[[noreturn]] void reject(const std::string& what, const std::string& problem) {
  throw std::invalid_argument(what + " " + problem);
}

std::string format(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  std::ostringstream text;
  text << matrix.format(kOneLine);
  return text.str();
}

std::string nameOf(KeyframeId id) { return "keyframe " + std::to_string(id.value); }

std::string nameOf(const PoseEdge& edge) {
  return "the edge from " + nameOf(edge.a) + " to " + nameOf(edge.b);
}

void requireRigid(const std::string& what, const Pose& pose) {
  if (isRigid(pose)) return;
  reject(what,
         "has the pose " + format(pose.matrix()) + ", expected finite numbers and a rotation");
}

void requireInformation(const PoseEdge& edge) {
  const Matrix6d& information = edge.information;
  const bool is_valid = information.allFinite() &&
                        information.isApprox(information.transpose(), 1e-9) &&
                        information.llt().info() == Eigen::Success;
  if (is_valid) return;
  reject(nameOf(edge), "has the information " + format(information) +
                           ", expected a symmetric positive definite matrix");
}

KeyframeId idOf(const GraphKeyframe& keyframe) { return keyframe.id; }

}  // namespace

Vector6d computeError(const PoseEdge& edge, const Pose& T_world_a, const Pose& T_world_b) {
  return toVector(edge.T_a_b.inverse() * T_world_a.inverse() * T_world_b);
}

Vector6d computeError(const PoseEdge& edge, const PoseGraphConfig& config, const OdometryBias& bias,
                      const Pose& T_world_a, const Pose& T_world_b) {
  if (!isBiased(edge, config)) return computeError(edge, T_world_a, T_world_b);
  return computeBiasedError(edge.T_a_b, bias, T_world_a.inverse() * T_world_b);
}

PoseGraph::PoseGraph(const PoseGraphConfig& config) : config_(config) {
  config::validate(config, "pose graph");
}

const GraphKeyframe* PoseGraph::find(KeyframeId id) const {
  const auto found = findById(keyframes_, id, idOf);
  return found == keyframes_.end() ? nullptr : &*found;
}

std::size_t PoseGraph::indexOf(KeyframeId id) const {
  return static_cast<std::size_t>(find(id) - keyframes_.data());
}

void PoseGraph::addKeyframe(KeyframeId id, const Pose& T_world_keyframe) {
  if (!id.isValid()) reject("a keyframe", "has the id 0, expected ids from 1 on");
  if (find(id) != nullptr) reject(nameOf(id), "is there already");
  requireRigid(nameOf(id), T_world_keyframe);
  const auto after =
      std::lower_bound(keyframes_.begin(), keyframes_.end(), id,
                       [](const GraphKeyframe& x, KeyframeId y) { return x.id < y; });
  keyframes_.insert(after, {id, T_world_keyframe});
}

void PoseGraph::extend(const PoseEdge& odometry) {
  const GraphKeyframe* a = find(odometry.a);
  if (a == nullptr) reject(nameOf(odometry), "begins at a keyframe that is not there");
  if (odometry.kind != EdgeKind::kOdometry) reject(nameOf(odometry), "is no odometry");
  requireRigid(nameOf(odometry), odometry.T_a_b);
  requireInformation(odometry);
  const Pose T_a_b = hasBias(config_) ? correctOdometry(odometry.T_a_b, bias_) : odometry.T_a_b;
  addKeyframe(odometry.b, a->T_world_keyframe * T_a_b);
  edges_.push_back(odometry);
  verdicts_.push_back(Verdict::kBelieved);
}

void PoseGraph::addEdge(const PoseEdge& edge) {
  for (const KeyframeId id : {edge.a, edge.b}) {
    if (find(id) == nullptr) reject(nameOf(edge), "names " + nameOf(id) + ", which is not there");
  }
  if (edge.a == edge.b) reject(nameOf(edge), "leads nowhere, expected two keyframes");
  requireRigid(nameOf(edge), edge.T_a_b);
  requireInformation(edge);
  edges_.push_back(edge);
  verdicts_.push_back(Verdict::kUndecided);
}

double PoseGraph::computeChi2() const {
  double chi2 = 0.0;
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const PoseEdge& edge = edges_[i];
    if (edge.kind == EdgeKind::kLoop && verdicts_[i] != Verdict::kBelieved) continue;
    const Vector6d error = computeError(edge, config_, bias_, find(edge.a)->T_world_keyframe,
                                        find(edge.b)->T_world_keyframe);
    chi2 += error.dot(edge.information * error);
  }
  return chi2;
}

}  // namespace tsg::trajectory
