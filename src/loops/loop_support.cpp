// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/loops/loop_support.h"

#include <algorithm>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/trajectory/se3.h"

namespace tsg::loops {
namespace {

using trajectory::computeAngle;
using trajectory::KeyframeId;
using trajectory::Matrix6d;
using trajectory::PoseEdge;
using trajectory::Vector6d;

Matrix6d move(const Matrix6d& covariance, const Pose& T) {
  const Matrix6d adjoint = trajectory::computeAdjoint(T);
  return adjoint * covariance * adjoint.transpose();
}

}  // namespace

LoopSupport::LoopSupport(const trajectory::Keyframes& keyframes,
                         const trajectory::OdometryNoise& noise, const SupportConfig& config,
                         const trajectory::PoseGraphConfig& bias)
    : keyframes_(keyframes), noise_(noise), config_(config), bias_(bias) {
  config::validate(config, "support");
}

/// Stops as soon as the way is too long: O(keyframes within it).
LoopSupport::Leg LoopSupport::measure(KeyframeId a, KeyframeId b) const {
  const auto& list = keyframes_.list();
  Leg leg;
  Eigen::Matrix<double, 6, 4> by_bias = Eigen::Matrix<double, 6, 4>::Zero();
  for (std::size_t k = std::min(a.value, b.value); k < std::max(a.value, b.value); ++k) {
    const PoseEdge step = trajectory::makeOdometryEdge(list[k - 1], list[k], noise_);
    leg.way_m += step.T_a_b.translation().norm() + computeAngle(step.T_a_b);
    if (leg.way_m > config_.max_way_m) return leg;
    const Pose back = step.T_a_b.inverse();
    leg.T_a_b = leg.T_a_b * step.T_a_b;
    leg.covariance = move(leg.covariance, back) + step.information.inverse();
    by_bias = trajectory::computeAdjoint(back) * by_bias +
              trajectory::computeBiasJacobian(step.T_a_b, bias_);
  }
  leg.covariance += by_bias * by_bias.transpose();
  if (b < a) leg = {leg.way_m, leg.T_a_b.inverse(), move(leg.covariance, leg.T_a_b)};
  return leg;
}

bool LoopSupport::doAgree(const PoseEdge& x, const PoseEdge& y) const {
  const Leg first = measure(x.a, y.a);
  const Leg second = measure(x.b, y.b);
  if (first.way_m > config_.max_way_m || second.way_m > config_.max_way_m) return false;
  const Pose back = second.T_a_b.inverse();
  const Vector6d error = trajectory::toVector(x.T_a_b.inverse() * first.T_a_b * y.T_a_b * back);
  const Matrix6d covariance = x.information.inverse() +
                              move(y.information.inverse() + second.covariance, second.T_a_b) +
                              move(first.covariance, second.T_a_b * y.T_a_b.inverse());
  return error.dot(covariance.ldlt().solve(error)) <= config_.max_chi2;
}

bool LoopSupport::isSupported(const PoseEdge& edge, const std::vector<PoseEdge>& all) const {
  if (config_.max_way_m == 0.0) return true;
  for (const PoseEdge& other : all) {
    if (other.a == edge.a && other.b == edge.b) continue;
    if (doAgree(edge, other)) return true;
  }
  return false;
}

}  // namespace tsg::loops
