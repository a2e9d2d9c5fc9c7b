// SPDX-License-Identifier: BSD-3-Clause
#include "path_draft.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tsg::planning {
namespace {

using Node = NavigationGrid::Node;

/// Each join costs a look along a line.
constexpr std::size_t kMaxJoins = 8;
/// King's moves are at most this much longer than the straight way.
constexpr double kKingsDetour = 1.0824;
/// A path that is longer than the straight line by less is not looked at again.
constexpr double kStraightEnough = 1.01;

/// Appends a straight piece, or, where that is not free, a way over cells that is not much longer.
bool appendLeg(const NavigationGrid& grid, const Waypoint& to, double radius_m, Waypoints& path) {
  const Waypoint from = path.back();
  if (!canWalk(grid, from, to, radius_m)) {
    constexpr double kMaxDetour = 3.0;
    GridSearchOptions options;
    options.radius_m = radius_m;
    options.max_length_m = kMaxDetour * (to.position_m - from.position_m).norm() + 1.0;
    if (!grid.isPassable(from.node, radius_m)) return false;
    const auto way = searchGrid(grid, from.node, {{to.node}, to.position_m, 0.0}, options);
    if (way.empty()) return false;
    const Waypoints cells = toWaypoints(grid, way);
    path.insert(path.end(), cells.begin(), cells.end());
  }
  path.push_back(to);
  return true;
}

std::optional<PathDraft> followPlaces(const NavigationGrid& grid, const PlaceRouter& router,
                                      const RoomyEnd& start, const PathGoals& goals,
                                      double radius_m, double join_distance_m) {
  const auto starts = findJoins(grid, router, start, 0, radius_m, join_distance_m);
  std::vector<PlaceRouter::Join> exits;
  for (std::size_t i = 0; i < goals.ends.size(); ++i) {
    const auto joins = findJoins(grid, router, goals.ends[i], i, radius_m, join_distance_m);
    exits.insert(exits.end(), joins.begin(), joins.end());
  }
  // Places may lie as much higher than their floor as the focus, or less.
  const double reach_m = goals.reach_m + 2.0;
  const auto route = router.findRoute(starts, exits, goals.focus_m, reach_m, radius_m);
  if (!route) return std::nullopt;
  PathDraft draft;
  draft.goal = route->goal;
  draft.waypoints = {start.waypoint};
  for (const std::size_t place : route->places) {
    const Eigen::Vector3d& place_m = router.position(place);
    const Waypoint waypoint{grid.findFloor(place_m), place_m.head<2>()};
    if (waypoint.node == NavigationGrid::kNone) return std::nullopt;
    if (!appendLeg(grid, waypoint, radius_m, draft.waypoints)) return std::nullopt;
    draft.places.push_back(router.id(place));
  }
  if (!appendLeg(grid, goals.ends[draft.goal].waypoint, radius_m, draft.waypoints)) {
    return std::nullopt;
  }
  draft.waypoints = pullTaut(grid, std::move(draft.waypoints), radius_m);
  draft.length_m = computeLength(grid, draft.waypoints);
  return draft;
}

std::optional<PathDraft> searchCells(const NavigationGrid& grid, const RoomyEnd& start,
                                     const PathGoals& goals, const GridSearchOptions& options) {
  GridGoals cells{{}, goals.focus_m.head<2>(), goals.reach_m + grid.cellSize()};
  for (const RoomyEnd& end : goals.ends) cells.nodes.push_back(end.node);
  const auto way = searchGrid(grid, start.node, cells, options);
  if (way.empty()) return std::nullopt;
  PathDraft draft;
  const auto end = std::find(cells.nodes.begin(), cells.nodes.end(), way.back());
  draft.goal = static_cast<std::size_t>(end - cells.nodes.begin());
  draft.waypoints = toWaypoints(grid, way);
  draft.waypoints.insert(draft.waypoints.begin(), start.waypoint);
  draft.waypoints.push_back(goals.ends[draft.goal].waypoint);
  draft.waypoints = pullTaut(grid, std::move(draft.waypoints), options.radius_m);
  draft.length_m = computeLength(grid, draft.waypoints);
  return draft;
}

/// False if the cells that may lie on a shorter path are too many to be looked at: those of an
/// ellipse round both ends, of which walls and unknown space take some share.
bool isWorthSearching(const PathDraft& draft, double straight_m, double cell_size_m,
                      int max_search_cells) {
  constexpr double kShareOfFree = 0.25;
  const double major_m = kKingsDetour * draft.length_m / 2.0;
  const double minor_m =
      std::sqrt(std::max(0.0, major_m * major_m - straight_m * straight_m / 4.0));
  const double cells = M_PI * major_m * minor_m / (cell_size_m * cell_size_m);
  return draft.length_m > kStraightEnough * straight_m && kShareOfFree * cells <= max_search_cells;
}

}  // namespace

std::vector<PlaceRouter::Join> findJoins(const NavigationGrid& grid, const PlaceRouter& router,
                                         const RoomyEnd& end, std::size_t index, double radius_m,
                                         double max_distance_m) {
  std::vector<PlaceRouter::Join> joins;
  Eigen::Vector3d p_m = grid.computePosition(end.waypoint.node);
  p_m.head<2>() = end.waypoint.position_m;
  for (const std::size_t place : router.findNear(p_m, max_distance_m)) {
    const Eigen::Vector3d& place_m = router.position(place);
    const Node node = grid.findFloor(place_m);
    if (node == NavigationGrid::kNone) continue;
    if (!canWalk(grid, end.waypoint, {node, place_m.head<2>()}, radius_m)) continue;
    joins.push_back({place, (place_m.head<2>() - p_m.head<2>()).norm(), index});
    if (joins.size() == kMaxJoins) break;
  }
  return joins;
}

std::optional<PathDraft> findDraft(const NavigationGrid& grid, const PlaceRouter& router,
                                   const RoomyEnd& start, const PathGoals& goals, double radius_m,
                                   const PlannerConfig& config) {
  auto draft = followPlaces(grid, router, start, goals, radius_m, config.join_distance_m);
  GridSearchOptions options;
  options.radius_m = radius_m;
  if (draft) {
    const Eigen::Vector2d away_m = goals.focus_m.head<2>() - start.waypoint.position_m;
    const double straight_m = std::max(0.0, away_m.norm() - goals.reach_m);
    if (!isWorthSearching(*draft, straight_m, grid.cellSize(), config.max_search_cells)) {
      return draft;
    }
    options.max_cells = static_cast<std::size_t>(config.max_search_cells);
    options.max_length_m = kKingsDetour * draft->length_m;
  }
  auto searched = searchCells(grid, start, goals, options);
  const bool is_shorter = searched && (!draft || searched->length_m < draft->length_m);
  return is_shorter ? searched : draft;
}

Path drawPath(const NavigationGrid& grid, const Waypoints& waypoints, double spacing_m) {
  Path path;
  path.length_m = computeLength(grid, waypoints);
  path.least_clearance_m = std::numeric_limits<double>::infinity();
  const auto append = [&](Node node, const Eigen::Vector2d& p_m, double yaw_rad) {
    const Eigen::Vector3d position_m(p_m.x(), p_m.y(),
                                     static_cast<double>(grid.cell(node).floor_m));
    path.points.push_back({position_m, yaw_rad});
    const double clearance_m = grid.computeClearance(node, p_m);
    if (clearance_m >= path.least_clearance_m) return;
    path.least_clearance_m = clearance_m;
    path.narrowest_m = position_m;
  };
  double yaw_rad = 0.0;
  for (std::size_t i = 0; i + 1 < waypoints.size(); ++i) {
    const Eigen::Vector2d& from_m = waypoints[i].position_m;
    const Eigen::Vector2d along_m = waypoints[i + 1].position_m - from_m;
    if (along_m.norm() > 0.0) yaw_rad = std::atan2(along_m.y(), along_m.x());
    const double pieces = std::max(1.0, std::ceil(along_m.norm() / spacing_m - 1e-6));
    for (double piece = 0.0; piece < pieces; piece += 1.0) {
      const Eigen::Vector2d p_m = from_m + along_m * (piece / pieces);
      const Node node = grid.walk(waypoints[i].node, from_m, p_m, 0.0);
      append(node == NavigationGrid::kNone ? waypoints[i].node : node, p_m, yaw_rad);
    }
  }
  append(waypoints.back().node, waypoints.back().position_m, yaw_rad);
  return path;
}

}  // namespace tsg::planning
