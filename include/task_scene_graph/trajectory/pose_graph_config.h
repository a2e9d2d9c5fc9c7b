// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/config/visitor.h"

namespace tsg::trajectory {

/// How a pose graph is solved, and which of its loop closures are believed. The chi2 of an edge is
/// e^T Omega e; of true ones with honest information, 99.9 % are below 22.5 (6 degrees of freedom).
struct PoseGraphConfig {
  int max_iterations = 100;
  double min_relative_decrease = 1e-8;
  double max_loop_chi2 = 22.5;
  double max_gate_chi2 = 22.5;
  double max_odometry_chi2 = 100.0;
  double gnc_factor = 2.0;
  double odometry_scale = 0.0;
  double odometry_turn_rad_per_m = 0.0;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("max_iterations", self.max_iterations, {1.0, 10000.0}, "",
            "of the solver; a graph that takes more stays as it was");
    v.field("min_relative_decrease", self.min_relative_decrease, {1e-14, 1e-2}, "",
            "the solver stops when a step lowers the cost by less than this share");
    v.field("max_loop_chi2", self.max_loop_chi2, {0.1, 1e6}, "",
            "a loop closure is believed if its chi2 in the corrected graph is at most this");
    v.field("max_gate_chi2", self.max_gate_chi2, {0.1, 1e12}, "",
            "... and at most this against odometry alone, with the drift that its information "
            "allows");
    v.field("max_odometry_chi2", self.max_odometry_chi2, {0.1, 1e12}, "",
            "a graph that bends an odometry edge more than this contradicts itself, and stays as "
            "it was");
    v.field("gnc_factor", self.gnc_factor, {1.05, 10.0}, "",
            "from round to round the threshold sharpens by this factor where loop closures "
            "contradict each other");
    v.field("odometry_scale", self.odometry_scale, {0.0, 1.0}, "",
            "deviation of a scale that all of odometry's ways share, which is estimated with the "
            "poses; 0: they have none");
    v.field("odometry_turn_rad_per_m", self.odometry_turn_rad_per_m, {0.0, 1.0}, "rad/m",
            "... of a turn with the way, likewise, of each axis");
  }
};

}  // namespace tsg::trajectory
