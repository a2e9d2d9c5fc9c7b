// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "task_scene_graph/core/id.h"
#include "task_scene_graph/core/oriented_box.h"

namespace tsg::planning {

/// Where a path leads: a point, or an object that the robot stops before and looks at.
struct Goal {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< world; at or above its floor
  std::optional<OrientedBox> object;                     ///< world; then `position_m` is not used
};

/// Something to plan.
struct PlanRequest {
  Eigen::Vector3d start_m = Eigen::Vector3d::Zero();  ///< world; at or above the robot's floor
  Goal goal;
  double robot_radius_m = 0.25;
};

struct PathPoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< on the floor; world
  double yaw_rad = 0.0;                                  ///< direction of travel
};

/// A way for the robot's axis.
struct Path {
  std::vector<PathPoint>
      points;             ///< `spacing_m` apart; the last looks at the object if there is one
  double length_m = 0.0;  ///< of the straight pieces that it consists of, in 3D
  double least_clearance_m = 0.0;  ///< to an observed obstacle, on the whole way
  Eigen::Vector3d narrowest_m = Eigen::Vector3d::Zero();  ///< where that is
  std::vector<PlaceId> places;  ///< the way over places that it was made from; empty without one
  bool has_view = true;         ///< nothing that was observed stands between its end and the object
};

enum class PlanStatus {
  kFound,
  kNoMap,         ///< neither places nor a ground plan
  kInvalid,       ///< a number that is not finite, or negative
  kStartOutside,  ///< no observed floor where the robot is
  kStartBlocked,  ///< the start lies in an obstacle
  kGoalOutside,   ///< no observed floor at the goal
  kGoalBlocked,   ///< the robot has no room at the goal nor near it
  kNoWay          ///< see Blockage
};

/// What is between a start and a goal that no path joins.
struct Blockage {
  enum class Kind {
    kUnknown,   ///< space that was not observed
    kObstacle,  ///< something solid
    kNarrow     ///< free space with less clearance than the robot's radius
  };
  Kind kind = Kind::kUnknown;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< where the cheapest way is cut; world
  PlaceId last_place;  ///< of all places that can be reached the nearest to the goal; may be none
  Eigen::Vector3d last_m =
      Eigen::Vector3d::Zero();  ///< its position, or that of such a cell; world
};

struct PlanResult {
  PlanStatus status = PlanStatus::kNoMap;
  Path path;                         ///< of kFound
  std::optional<Blockage> blockage;  ///< of kNoWay
  std::string message;  ///< what went wrong or is worth knowing, for people; "" if nothing is

  bool isFound() const { return status == PlanStatus::kFound; }
};

}  // namespace tsg::planning
