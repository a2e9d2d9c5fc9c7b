// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "navigation_grid.h"

namespace tsg::planning {

/// A corner of a path, and the cell of the floor that it lies on.
struct Waypoint {
  NavigationGrid::Node node = NavigationGrid::kNone;
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
};

using Waypoints = std::vector<Waypoint>;

/// True if the robot's axis can walk straight from one to the other.
bool canWalk(const NavigationGrid& grid, const Waypoint& from, const Waypoint& to, double radius_m);

Waypoints toWaypoints(const NavigationGrid& grid, const std::vector<NavigationGrid::Node>& way);

/// Shortens a path of walkable pieces as a string that is pulled: corners are left out where one
/// can walk straight past, and cut as far as the clearance allows. Its ends stay; it is never
/// longer than before, and walkable.
Waypoints pullTaut(const NavigationGrid& grid, Waypoints path, double radius_m);

/// Length of the straight pieces, with the heights of the floor at their ends.
double computeLength(const NavigationGrid& grid, const Waypoints& path);

}  // namespace tsg::planning
