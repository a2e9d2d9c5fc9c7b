// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/trajectory/trajectory_error.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace tsg::trajectory {
namespace {

constexpr double kMaxGap_s = 0.5;

Pose findTruth(const Trajectory& truth, std::int64_t ns) {
  const auto pose = truth.interpolate({ns}, kMaxGap_s);
  if (!pose) {
    throw std::invalid_argument("no true pose at stamp " + std::to_string(ns) +
                                " ns, expected one within 0.5 s before and after");
  }
  return *pose;
}

}  // namespace

double computeTrajectoryError(const Trajectory& truth, const Trajectory& estimate) {
  if (estimate.isEmpty()) throw std::invalid_argument("no pose, expected a trajectory");
  const auto& [first_ns, first] = *estimate.poses().begin();
  const Pose T_truth_estimate = findTruth(truth, first_ns) * first.inverse();
  double squares = 0.0;
  for (const auto& [ns, pose] : estimate.poses()) {
    const Eigen::Vector3d true_m = findTruth(truth, ns).translation();
    squares += (T_truth_estimate * pose.translation() - true_m).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(estimate.size()));
}

}  // namespace tsg::trajectory
