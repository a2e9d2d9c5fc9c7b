// SPDX-License-Identifier: BSD-3-Clause
#include "path_ends.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

namespace tsg::planning {
namespace {

using Node = NavigationGrid::Node;

std::string formatLength(double length_m) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.2f m", length_m);
  return text.data();
}

bool isObstacle(const NavigationGrid& grid, Node node) {
  return node != NavigationGrid::kNone &&
         grid.cell(node).state == places::PlanCell::State::kObstacle;
}

/// The end at a point with room; none if no centre of a cell beside it can be walked to.
std::optional<RoomyEnd> findRoomyEnd(const NavigationGrid& grid, Node node,
                                     const Eigen::Vector2d& p_m, double radius_m) {
  if (!grid.isClear(node, p_m, radius_m)) return std::nullopt;
  for (const int dy : {0, -1, 1}) {
    for (const int dx : {0, -1, 1}) {
      const Node beside = grid.findNeighbour(node, dx, dy);
      if (beside == NavigationGrid::kNone || !grid.isPassable(beside, radius_m)) continue;
      const Waypoint end{node, p_m};
      if (canWalk(grid, end, {beside, grid.computeCenter(beside)}, radius_m)) {
        return RoomyEnd{end, beside};
      }
    }
  }
  return std::nullopt;
}

RoomyEnd makeCellEnd(const NavigationGrid& grid, Node node) {
  return {{node, grid.computeCenter(node)}, node};
}

/// The cell nearest to a point, at most `max_distance_m` away, of those that `isWanted`.
template <typename Wanted>
Node findNearestCell(const NavigationGrid& grid, const Eigen::Vector3d& p_m, double max_distance_m,
                     const Wanted& isWanted) {
  const int cells = static_cast<int>(std::ceil(max_distance_m / grid.cellSize()));
  Node best = NavigationGrid::kNone;
  double best_m = max_distance_m;
  for (int y = -cells; y <= cells; ++y) {
    for (int x = -cells; x <= cells; ++x) {
      const Node node = grid.findFloor(p_m + grid.cellSize() * Eigen::Vector3d(x, y, 0.0));
      if (node == NavigationGrid::kNone || !isWanted(node)) continue;
      const double away_m = (grid.computeCenter(node) - p_m.head<2>()).norm();
      if (away_m > best_m || (best != NavigationGrid::kNone && away_m == best_m)) continue;
      best = node;
      best_m = away_m;
    }
  }
  return best;
}

/// A start in a cell that is not wide enough.
PathStart escapeFrom(const NavigationGrid& grid, Node node, const Eigen::Vector2d& p_m,
                     double radius_m, double max_distance_m) {
  PathStart start;
  const std::vector<Node> way = findRoom(grid, node, radius_m, max_distance_m);
  if (way.empty()) {
    start.status = PlanStatus::kStartBlocked;
    start.message = "the robot has no room where it is, nor within " +
                    formatLength(max_distance_m) + " of it: no free space " +
                    formatLength(radius_m) + " from all obstacles";
    return start;
  }
  start.escape = toWaypoints(grid, way);
  start.escape.insert(start.escape.begin(), {node, p_m});
  start.escape = pullTaut(grid, std::move(start.escape), 0.0);
  start.escape.pop_back();
  start.end = makeCellEnd(grid, way.back());
  start.message =
      "the robot stands nearer to an obstacle than its radius of " + formatLength(radius_m);
  return start;
}

/// Point of a box, seen from above, that is nearest to another.
Eigen::Vector2d findNearestOfBox(const OrientedBox& box, const Eigen::Vector2d& p_m) {
  const Eigen::Rotation2Dd turn(box.yaw_rad);
  const Eigen::Vector2d center_m = box.center_m.head<2>();
  const Eigen::Vector2d half_m = box.size_m.head<2>() / 2.0;
  const Eigen::Vector2d local_m = turn.inverse() * (p_m - center_m);
  return center_m + turn * local_m.cwiseMax(-half_m).cwiseMin(half_m);
}

/// Length of what is not free on the straight line to the box, but for the last half cell before
/// it. Infinite if the line leaves free space, meets it again and leaves it once more: then
/// something stands apart from the object, in front of it.
double computeHidden(const NavigationGrid& grid, Node from, const Eigen::Vector2d& to_m) {
  const Eigen::Vector2d from_m = grid.computeCenter(from);
  const double length_m = (to_m - from_m).norm() - 0.5 * grid.cellSize();
  const double step_m = grid.cellSize() / 2.0;
  const auto floor_m = static_cast<double>(grid.cell(from).floor_m);
  const Eigen::Vector2d along = (to_m - from_m).normalized();
  double hidden_m = 0.0;
  for (double at_m = 0.0; at_m < length_m; at_m += step_m) {
    const auto* cell =
        grid.plan().find(grid.plan().computeCell(from_m + along * at_m), floor_m, grid.maxStep());
    const bool is_free = cell != nullptr && cell->isFree();
    if (is_free && hidden_m > 0.0) return std::numeric_limits<double>::infinity();
    if (!is_free) hidden_m += step_m;
  }
  return hidden_m;
}

struct Candidate {
  Node node = NavigationGrid::kNone;
  double away_m = 0.0;    ///< from the box
  double hidden_m = 0.0;  ///< computeHidden()
};

std::vector<Candidate> findCandidates(const NavigationGrid& grid, const OrientedBox& box,
                                      double radius_m, const PlannerConfig& config) {
  const double nearest_m = radius_m + config.stand_off_m;
  const double farthest_m = radius_m + std::max(config.stand_off_m, config.max_stand_off_m);
  const double extent_m = box.size_m.head<2>().norm() / 2.0 + farthest_m;
  const double bottom_m = box.center_m.z() - box.size_m.z() / 2.0;
  const int cells = static_cast<int>(std::ceil(extent_m / grid.cellSize()));
  std::vector<Candidate> found;
  for (int y = -cells; y <= cells; ++y) {
    for (int x = -cells; x <= cells; ++x) {
      const Node node = grid.findFloor(box.center_m + grid.cellSize() * Eigen::Vector3d(x, y, 0));
      if (node == NavigationGrid::kNone || !grid.isPassable(node, radius_m)) continue;
      const auto floor_m = static_cast<double>(grid.cell(node).floor_m);
      if (floor_m > box.center_m.z() + grid.maxStep()) continue;
      if (bottom_m - floor_m > config.max_reach_height_m) continue;
      const Eigen::Vector2d nearest = findNearestOfBox(box, grid.computeCenter(node));
      const double away_m = (grid.computeCenter(node) - nearest).norm();
      if (away_m < nearest_m || away_m > farthest_m) continue;
      found.push_back({node, away_m, computeHidden(grid, node, nearest)});
    }
  }
  return found;
}

/// Of each direction the nearest to the box of those with the least in between, if it is not much
/// farther than the nearest of all.
std::vector<Candidate> selectBest(const NavigationGrid& grid,
                                  const std::vector<Candidate>& candidates,
                                  const OrientedBox& box) {
  constexpr int kDirections = 16;
  constexpr double kMuchFarther_m = 0.2;
  double least_m = std::numeric_limits<double>::infinity();
  for (const Candidate& c : candidates) least_m = std::min(least_m, c.hidden_m);
  // A wall behind the object may be no thicker than a cell.
  const double limit_m = least_m + 0.6 * grid.cellSize();
  double nearest_m = std::numeric_limits<double>::infinity();
  std::array<Candidate, kDirections> best{};
  for (const Candidate& c : candidates) {
    if (c.hidden_m > limit_m) continue;
    const Eigen::Vector2d from_m = grid.computeCenter(c.node) - box.center_m.head<2>();
    const double turns = std::atan2(from_m.y(), from_m.x()) / (2.0 * M_PI) + 0.5;
    Candidate& other = best[static_cast<std::size_t>(turns * kDirections) % kDirections];
    if (other.node == NavigationGrid::kNone || c.away_m < other.away_m) other = c;
    nearest_m = std::min(nearest_m, c.away_m);
  }
  std::vector<Candidate> selected;
  for (const Candidate& c : best) {
    const bool is_near = c.away_m <= nearest_m + kMuchFarther_m;
    if (c.node != NavigationGrid::kNone && is_near) selected.push_back(c);
  }
  return selected;
}

}  // namespace

std::string formatPoint(const Eigen::Vector3d& p_m) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "(%.2f, %.2f, %.2f)", p_m.x(), p_m.y(), p_m.z());
  return text.data();
}

PathStart findStart(const NavigationGrid& grid, const PlanRequest& request,
                    const PlannerConfig& config) {
  PathStart start;
  const double radius_m = request.robot_radius_m;
  Eigen::Vector2d p_m = request.start_m.head<2>();
  Node node = grid.findFloor(request.start_m);
  if (isObstacle(grid, node)) {
    start.status = PlanStatus::kStartBlocked;
    start.message = "the start " + formatPoint(request.start_m) + " is inside an obstacle";
    return start;
  }
  std::string message;
  if (node == NavigationGrid::kNone || !grid.cell(node).isFree()) {
    node = findNearestCell(grid, request.start_m, config.goal_tolerance_m,
                           [&](Node candidate) { return grid.cell(candidate).isFree(); });
    if (node == NavigationGrid::kNone) {
      start.status = PlanStatus::kStartOutside;
      start.message = "the start " + formatPoint(request.start_m) +
                      " is outside the observed floor, and none is within " +
                      formatLength(config.goal_tolerance_m) + " of it";
      return start;
    }
    p_m = grid.computeCenter(node);
    message = "the floor at the start was not observed: the path begins " +
              formatLength((p_m - request.start_m.head<2>()).norm()) + " beside it";
  }
  if (const auto end = findRoomyEnd(grid, node, p_m, radius_m)) {
    start.end = *end;
    start.message = message;
    return start;
  }
  return escapeFrom(grid, node, p_m, radius_m, radius_m + config.goal_tolerance_m);
}

PathGoals findPointGoal(const NavigationGrid& grid, const Eigen::Vector3d& goal_m, double radius_m,
                        const PlannerConfig& config) {
  PathGoals goals;
  goals.focus_m = goal_m;
  const Node node = grid.findFloor(goal_m);
  if (node != NavigationGrid::kNone) {
    const auto end = findRoomyEnd(grid, node, goal_m.head<2>(), radius_m);
    if (end) goals.ends.push_back(*end);
    if (end) return goals;
  }
  const Node near = findNearestCell(grid, goal_m, config.goal_tolerance_m, [&](Node candidate) {
    return grid.isPassable(candidate, radius_m);
  });
  const bool is_observed =
      node != NavigationGrid::kNone && grid.cell(node).state != places::PlanCell::State::kUnknown;
  if (near == NavigationGrid::kNone) {
    goals.status = is_observed ? PlanStatus::kGoalBlocked : PlanStatus::kGoalOutside;
    goals.message =
        "the goal " + formatPoint(goal_m) +
        (is_observed ? " is in or too near to an obstacle" : " is outside the observed floor") +
        ", and the robot has no room within " + formatLength(config.goal_tolerance_m) + " of it";
    return goals;
  }
  goals.ends.push_back(makeCellEnd(grid, near));
  goals.reach_m = (grid.computeCenter(near) - goal_m.head<2>()).norm();
  goals.message = "the robot has no room at the goal: the path ends " +
                  formatLength(goals.reach_m) + " beside it";
  return goals;
}

PathGoals findStandingPoints(const NavigationGrid& grid, const OrientedBox& box, double radius_m,
                             const PlannerConfig& config, StandingPoints which) {
  PathGoals goals;
  goals.focus_m = box.center_m;
  std::vector<Candidate> candidates = findCandidates(grid, box, radius_m, config);
  if (candidates.empty()) {
    goals.status = PlanStatus::kGoalBlocked;
    goals.message = "nowhere within " + formatLength(config.max_stand_off_m) +
                    " of the object at " + formatPoint(box.center_m) +
                    " the robot has room on observed floor";
    return goals;
  }
  if (which == StandingPoints::kBest) candidates = selectBest(grid, candidates, box);
  for (const Candidate& c : candidates) {
    goals.ends.push_back(makeCellEnd(grid, c.node));
    goals.ends.back().has_view = c.hidden_m <= 1.5 * grid.cellSize();
    const double away_m = (grid.computeCenter(c.node) - box.center_m.head<2>()).norm();
    goals.reach_m = std::max(goals.reach_m, away_m);
  }
  return goals;
}

}  // namespace tsg::planning
