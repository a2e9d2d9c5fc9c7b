// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "navigation_grid.h"
#include "place_router.h"
#include "task_scene_graph/planning/path.h"

namespace tsg::planning {

/// Why no path leads from a cell to a point. The cheapest way is looked for through everything in
/// the plan's tiles and those beside them, where unknown cells cost 3 free ones, narrow ones 4 and
/// obstacles 30; the first stretch of it on which the robot has no room is what is in the way: an
/// obstacle if one is in it, else unknown space if that is, else the narrowness. Where not even
/// such a way leads from tile to tile, unknown space is. O(cells * log).
Blockage findBlockage(const NavigationGrid& grid, const PlaceRouter& router,
                      NavigationGrid::Node start, const Eigen::Vector3d& goal_m, double radius_m);

/// The place that is nearest to the goal among those reached, by index.
/// @param is_reached  for each place of the router
void setLastPlace(const PlaceRouter& router, const std::vector<char>& is_reached,
                  const Eigen::Vector3d& goal_m, Blockage& blockage);

}  // namespace tsg::planning
