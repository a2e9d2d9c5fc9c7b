// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/places/ground_plan.h"
#include "task_scene_graph/planning/path.h"
#include "task_scene_graph/planning/planner_config.h"

namespace tsg::planning {

class NavigationGrid;
class PlaceRouter;

/// Plans paths: A* over the places, whose way is then pulled taut in the free space of the ground
/// plan; beside it A* over the cells themselves, as far as `max_search_cells` go, or all of them
/// where the places know no way. The shorter one wins. Without a ground plan (`free_space: volume`)
/// the way over places is all there is. Of one state of the map; immutable, so any number of
/// threads may plan at once.
class Planner {
 public:
  /// O(places * log(places) + tiles of the plan), which the two are shared with.
  /// @throws config::ConfigError naming every field out of range.
  Planner(const PlaceGraph& places, const places::GroundPlan& plan, const PlannerConfig& config);

  /// No point of the path has less clearance than the robot's radius, but for its beginning, if the
  /// robot stands where it has no room: Path::narrowest_m tells. The clearance is that of the
  /// plan's cells, bilinear between their centres. O((places + max_search_cells) * log) where the
  /// places know a way, else O(cells * log).
  PlanResult plan(const PlanRequest& request) const;

 private:
  PlanResult planOnGrid(const PlanRequest& request) const;
  PlanResult planOverPlaces(const PlanRequest& request) const;

  PlannerConfig config_;
  std::shared_ptr<const PlaceRouter> router_;
  std::shared_ptr<const NavigationGrid> grid_;
};

}  // namespace tsg::planning
