// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "path_ends.h"
#include "place_router.h"
#include "taut_path.h"

namespace tsg::planning {

/// A taut path between two roomy ends, before it is sampled and measured.
struct PathDraft {
  Waypoints waypoints;
  std::size_t goal = 0;  ///< index into PathGoals::ends
  double length_m = 0.0;
  std::vector<PlaceId> places;  ///< that it was made from; empty if none
};

/// Joins to places that an end sees, the nearest first, no more than eight.
std::vector<PlaceRouter::Join> findJoins(const NavigationGrid& grid, const PlaceRouter& router,
                                         const RoomyEnd& end, std::size_t index, double radius_m,
                                         double max_distance_m);

/// The shorter of the way over places and that over cells, both pulled taut (see Planner).
std::optional<PathDraft> findDraft(const NavigationGrid& grid, const PlaceRouter& router,
                                   const RoomyEnd& start, const PathGoals& goals, double radius_m,
                                   const PlannerConfig& config);

/// Samples a path and measures its clearance.
/// @param waypoints  at least one
Path drawPath(const NavigationGrid& grid, const Waypoints& waypoints, double spacing_m);

}  // namespace tsg::planning
