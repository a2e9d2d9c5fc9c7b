// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "grid_search.h"
#include "task_scene_graph/planning/path.h"
#include "task_scene_graph/planning/planner_config.h"
#include "taut_path.h"

namespace tsg::planning {

/// An end of a path where the robot has room, and the cell there whose centre it can walk to.
struct RoomyEnd {
  Waypoint waypoint;
  NavigationGrid::Node node = NavigationGrid::kNone;
  bool has_view = true;  ///< of the object, if there is one
};

/// The beginning of a path.
struct PathStart {
  PlanStatus status = PlanStatus::kFound;  ///< kStartOutside, kStartBlocked: nothing else is set
  Waypoints escape;  ///< from the robot to where it has room, that end left out; mostly empty
  RoomyEnd end;
  std::string message;  ///< what is wrong or worth knowing; mostly empty
};

/// The places at which a path may end, all within `reach_m` of `focus_m`.
struct PathGoals {
  PlanStatus status = PlanStatus::kFound;  ///< kGoalOutside, kGoalBlocked: nothing else is set
  std::vector<RoomyEnd> ends;
  Eigen::Vector3d focus_m = Eigen::Vector3d::Zero();  ///< the goal itself; world
  double reach_m = 0.0;
  std::string message;
};

/// Which of the cells round an object may be ends.
enum class StandingPoints { kBest, kAll };

PathStart findStart(const NavigationGrid& grid, const PlanRequest& request,
                    const PlannerConfig& config);
/// The point, or the nearest cell with room within `goal_tolerance_m`.
PathGoals findPointGoal(const NavigationGrid& grid, const Eigen::Vector3d& goal_m, double radius_m,
                        const PlannerConfig& config);

/// Cells round an object at which the robot has room, `stand_off_m` to `max_stand_off_m` from its
/// box to the robot's edge, on the highest floor that is not above the object's middle. The best:
/// in each of 16 directions the nearest of those with a free view of the box, or, if there is none,
/// with the least in between (what the object stands on). A wall behind the object is no better
/// than a table under it, so long as there is nothing in front. O(cells within the distance).
PathGoals findStandingPoints(const NavigationGrid& grid, const OrientedBox& box, double radius_m,
                             const PlannerConfig& config, StandingPoints which);

/// "(1.00, 2.00, 0.50)".
std::string formatPoint(const Eigen::Vector3d& p_m);

}  // namespace tsg::planning
