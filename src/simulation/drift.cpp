// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/drift.h"

#include <cmath>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/simulation/random.h"

namespace tsg::simulation {
namespace {

constexpr double kReference_m = 10.0;  ///< the way after which the error is as configured

Eigen::Vector3d drawNormals(Random& random) {
  const double x = random.normal();
  const double y = random.normal();
  return {x, y, random.normal()};
}

/// The error of one step, in world axes where the walk truly is.
class StepErrors {
 public:
  explicit StepErrors(const DriftConfig& config) : config_(config), random_(hashSeed(config)) {
    const double share = std::sqrt(config.systematic_share);
    scale_ = (random_.chance(0.5) ? share : -share) * config.position_per_m;
    curvature_rad_per_m_ = (random_.chance(0.5) ? share : -share) * config.angle_rad_per_m;
    random_share_ = std::sqrt(1.0 - config.systematic_share);
  }

  Pose draw(const Eigen::Vector3d& step_m) {
    const double way_m = step_m.norm();
    // A random walk's deviation after n steps of w is sigma sqrt(n w): as configured after 10 m.
    const double growth = random_share_ * std::sqrt(way_m * kReference_m);
    const Eigen::Vector3d position_m =
        scale_ * step_m + config_.position_per_m * growth / std::sqrt(3.0) * drawNormals(random_);
    Eigen::Vector3d turn_rad = config_.angle_rad_per_m * growth * drawNormals(random_);
    turn_rad.head<2>() *= config_.tilt_share;
    turn_rad.z() += curvature_rad_per_m_ * way_m;
    Pose error = Pose::Identity();
    error.translation() = position_m;
    const double angle_rad = turn_rad.norm();
    if (angle_rad > 0.0) {
      error.linear() = Eigen::AngleAxisd(angle_rad, turn_rad / angle_rad).toRotationMatrix();
    }
    return error;
  }

 private:
  static std::uint64_t hashSeed(const DriftConfig& config) {
    return combineSeeds(static_cast<std::uint64_t>(config.seed), hashText("drift"));
  }

  DriftConfig config_;
  Random random_;
  double scale_ = 0.0;
  double curvature_rad_per_m_ = 0.0;
  double random_share_ = 0.0;
};

/// The same motion in the axes of the camera.
Pose toCameraAxes(const Pose& motion_world, const Eigen::Matrix3d& R_world_camera) {
  Pose motion = Pose::Identity();
  motion.linear() = R_world_camera.transpose() * motion_world.linear() * R_world_camera;
  motion.translation() = R_world_camera.transpose() * motion_world.translation();
  return motion;
}

Pose withRotationOfUnitLength(Pose pose) {
  pose.linear() = Eigen::Quaterniond(pose.linear()).normalized().toRotationMatrix();
  return pose;
}

}  // namespace

std::vector<WalkPose> simulateDrift(const std::vector<WalkPose>& walk, const DriftConfig& config) {
  config::validate(config, "drift");
  StepErrors errors(config);
  std::vector<WalkPose> odometry = walk;
  for (std::size_t i = 1; i < walk.size(); ++i) {
    const Pose& T_before = walk[i - 1].T_world_camera;
    const Pose& T_now = walk[i].T_world_camera;
    const Pose error = errors.draw(T_now.translation() - T_before.translation());
    odometry[i].T_world_camera =
        withRotationOfUnitLength(odometry[i - 1].T_world_camera * (T_before.inverse() * T_now) *
                                 toCameraAxes(error, T_now.linear()));
  }
  return odometry;
}

}  // namespace tsg::simulation
