// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <vector>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/simulation/apartment.h"
#include "task_scene_graph/simulation/drift.h"
#include "task_scene_graph/simulation/walk.h"
#include "task_scene_graph/trajectory/keyframes.h"

namespace tsg {

/// A walk of some laps through a generated apartment, with odometry that drifts.
struct DriftingWalk {
  simulation::Apartment apartment;
  std::vector<simulation::WalkPose> truth;
  std::vector<simulation::WalkPose> odometry;
};

inline DriftingWalk makeDriftingWalk(int seed, int num_rooms, int laps, double drift) {
  DriftingWalk walk;
  walk.apartment = simulation::buildApartment({seed, num_rooms});
  simulation::WalkConfig config;
  config.laps = laps;
  walk.truth = simulation::planWalk(walk.apartment, config);
  simulation::DriftConfig drift_config;
  drift_config.position_per_m = drift;
  drift_config.seed = seed;
  walk.odometry = simulation::simulateDrift(walk.truth, drift_config);
  return walk;
}

/// Indices of the poses that are keyframes by odometry.
inline std::vector<std::size_t> selectPoses(const DriftingWalk& walk,
                                            const trajectory::KeyframeConfig& config) {
  trajectory::Keyframes keyframes("odom", config);
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < walk.odometry.size(); ++i) {
    if (keyframes.add(walk.odometry[i].stamp, walk.odometry[i].T_world_camera)) {
      indices.push_back(i);
    }
  }
  return indices;
}

/// Root mean square distance of keyframes from where they truly were; both begin at one pose.
template <typename PoseAt>
double computeTrajectoryError(const DriftingWalk& walk, const std::vector<std::size_t>& keyframes,
                              const PoseAt& poseAt) {
  double squares = 0.0;
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    const Eigen::Vector3d truth_m = walk.truth[keyframes[k]].T_world_camera.translation();
    squares += (poseAt(k).translation() - truth_m).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(keyframes.size()));
}

}  // namespace tsg
