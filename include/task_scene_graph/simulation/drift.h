// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "task_scene_graph/simulation/walk.h"

namespace tsg::simulation {

/// How odometry drifts. Position and heading each have a part that goes to one side all the time
/// and one that is a random walk; after 10 m of straight way their root mean square is as given.
struct DriftConfig {
  double position_per_m = 0.02;
  double angle_rad_per_m = 0.0017453292519943296;  // 1 degree after 10 m
  double systematic_share = 0.5;
  double tilt_share = 0.1;
  int seed = 1;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("position_per_m", self.position_per_m, {0.0, 1.0}, "",
            "error of the position, as a share of the way, after 10 m");
    v.field("angle_rad_per_m", self.angle_rad_per_m, {0.0, 1.0}, "rad/m",
            "error of the heading per way after 10 m");
    v.field("systematic_share", self.systematic_share, {0.0, 1.0}, "",
            "share of the variance after 10 m that goes to one side: 0 = random walk only");
    v.field("tilt_share", self.tilt_share, {0.0, 1.0}, "",
            "roll and pitch against the heading: gravity holds them");
    v.field("seed", self.seed, {0.0, 2147483647.0}, "", "the drift follows from it");
  }
};

/// What odometry makes of a walk: the same stamps and first pose; each motion is the true one, its
/// way too long or too short and its direction turned a little. The systematic part is a scale of
/// the way and a constant curvature, their signs drawn from the seed. O(poses). Deterministic.
/// @throws config::ConfigError
std::vector<WalkPose> simulateDrift(const std::vector<WalkPose>& walk, const DriftConfig& config);

}  // namespace tsg::simulation
