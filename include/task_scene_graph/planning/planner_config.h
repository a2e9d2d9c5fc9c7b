// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/config/visitor.h"

namespace tsg::planning {

/// The robot that paths are for, and where it stops before an object. Its height is the one that
/// the ground plan was made for (places/body_height_m).
struct PlannerConfig {
  double robot_radius_m = 0.25;
  double max_step_m = 0.2;  ///< as places/max_step_m of the plan, so no parameter of its own
  double goal_tolerance_m = 0.5;
  double stand_off_m = 0.3;
  double max_stand_off_m = 1.5;
  double max_reach_height_m = 2.5;
  double join_distance_m = 3.0;
  double spacing_m = 0.1;
  int max_search_cells = 10000;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("robot_radius_m", self.robot_radius_m, {0.0, 5.0}, "m",
            "radius of the robot seen from above; no path comes nearer to an obstacle");
    v.field("goal_tolerance_m", self.goal_tolerance_m, {0.0, 10.0}, "m",
            "a path to a point where the robot has no room ends so near to it");
    v.field("stand_off_m", self.stand_off_m, {0.0, 10.0}, "m",
            "least distance between the robot's edge and the box of an object that it goes to");
    v.field("max_stand_off_m", self.max_stand_off_m, {0.0, 10.0}, "m",
            "... and greatest, for objects that stand on something");
    v.field("max_reach_height_m", self.max_reach_height_m, {0.1, 20.0}, "m",
            "an object is gone to on the floor under it, if that is so near to its lower side");
    v.field("join_distance_m", self.join_distance_m, {0.1, 50.0}, "m",
            "start and goal are joined to places that they see within this distance");
    v.field("spacing_m", self.spacing_m, {0.01, 10.0}, "m", "between poses of a path");
    v.field("max_search_cells", self.max_search_cells, {0, 100000000}, "",
            "cells of the ground plan that are looked at for a shorter path than that over places; "
            "where there is no path over places, all cells are");
  }
};

}  // namespace tsg::planning
