// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/loops/loop_support.h"

#include <cmath>
#include <limits>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/trajectory/se3.h"

namespace tsg::loops {
namespace {

using trajectory::computeAngle;
using trajectory::KeyframeId;
using trajectory::PoseEdge;

/// Largest variances of an edge, of position and of angle.
std::pair<double, double> computeVariances(const PoseEdge& edge) {
  const trajectory::Matrix6d covariance = edge.information.inverse();
  return {covariance.diagonal().head<3>().maxCoeff(), covariance.diagonal().tail<3>().maxCoeff()};
}

}  // namespace

LoopSupport::LoopSupport(const trajectory::Keyframes& keyframes,
                         const trajectory::OdometryNoise& noise, const SupportConfig& config)
    : keyframes_(keyframes), noise_(noise), config_(config) {
  config::validate(config, "support");
}

/// Stops as soon as the way is too long: O(keyframes within it).
LoopSupport::Leg LoopSupport::measure(KeyframeId a, KeyframeId b) const {
  const auto& list = keyframes_.list();
  Leg leg{0.0, keyframes_.find(a)->T_world_camera.inverse() * keyframes_.find(b)->T_world_camera};
  for (std::size_t k = std::min(a.value, b.value); k < std::max(a.value, b.value); ++k) {
    const Pose step = list[k - 1].T_world_camera.inverse() * list[k].T_world_camera;
    leg.way_m += step.translation().norm() + computeAngle(step);
    if (leg.way_m > config_.max_way_m) break;
  }
  return leg;
}

bool LoopSupport::doAgree(const PoseEdge& x, const PoseEdge& y) const {
  const Leg first = measure(x.a, y.a);
  const Leg second = measure(x.b, y.b);
  if (first.way_m > config_.max_way_m || second.way_m > config_.max_way_m) return false;
  const Pose error = x.T_a_b.inverse() * first.T_a_b * y.T_a_b * second.T_a_b.inverse();
  const auto [x_m2, x_rad2] = computeVariances(x);
  const auto [y_m2, y_rad2] = computeVariances(y);
  const double way_m = first.way_m + second.way_m;
  const double rad2 = x_rad2 + y_rad2 + way_m * noise_.angle_rad * noise_.angle_rad;
  const double lever_m = first.T_a_b.translation().norm() + y.T_a_b.translation().norm() +
                         second.T_a_b.translation().norm();
  const double m2 =
      x_m2 + y_m2 + way_m * noise_.position_m * noise_.position_m + lever_m * lever_m * rad2;
  const double angle_rad = computeAngle(error);
  const double chi2 = error.translation().squaredNorm() / m2 + angle_rad * angle_rad / rad2;
  return chi2 <= config_.max_chi2;
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
