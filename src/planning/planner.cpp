// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/planning/planner.h"

#include <cmath>
#include <string>
#include <utility>

#include "blockage.h"
#include "path_draft.h"
#include "task_scene_graph/config/config.h"

namespace tsg::planning {
namespace {

PlanResult fail(PlanStatus status, std::string message) {
  PlanResult result;
  result.status = status;
  result.message = std::move(message);
  return result;
}

std::string joinMessages(const std::string& a, const std::string& b) {
  return a.empty() || b.empty() ? a + b : a + "; " + b;
}

/// What is wrong with the numbers of a request; "" if nothing is.
std::string findProblem(const PlanRequest& request) {
  if (!request.start_m.allFinite()) return "the start is not finite";
  const auto& object = request.goal.object;
  if (!object && !request.goal.position_m.allFinite()) return "the goal is not finite";
  if (object && !(object->center_m.allFinite() && object->size_m.allFinite() &&
                  std::isfinite(object->yaw_rad) && (object->size_m.array() >= 0.0).all())) {
    return "the object's box is not finite, or its size negative";
  }
  if (!std::isfinite(request.robot_radius_m) || request.robot_radius_m < 0.0) {
    return "the robot's radius is " + std::to_string(request.robot_radius_m) +
           " m, expected 0 or more";
  }
  // Beyond this, cells have no numbers.
  constexpr double kMaxCoordinate_m = 1e7;
  const Eigen::Vector3d& goal_m = object ? object->center_m : request.goal.position_m;
  const bool is_near = request.start_m.cwiseAbs().maxCoeff() < kMaxCoordinate_m &&
                       goal_m.cwiseAbs().maxCoeff() < kMaxCoordinate_m;
  return is_near ? "" : "the start or the goal is more than 10000 km from the origin";
}

std::string describe(Blockage::Kind kind) {
  switch (kind) {
    case Blockage::Kind::kObstacle:
      return "an obstacle is";
    case Blockage::Kind::kNarrow:
      return "a passage too narrow for the robot is";
    case Blockage::Kind::kUnknown:
      break;
  }
  return "space that was not observed is";
}

std::string describe(const Blockage& blockage) {
  const std::string last = blockage.last_place.isValid()
                               ? "place " + std::to_string(blockage.last_place.value)
                               : std::string("a cell with no place");
  return "no path: of all that can be reached, " + last + " at " + formatPoint(blockage.last_m) +
         " is nearest to the goal; " + describe(blockage.kind) + " in the way at " +
         formatPoint(blockage.position_m);
}

void lookAt(const Eigen::Vector3d& target_m, Path& path) {
  const Eigen::Vector3d along_m = target_m - path.points.back().position_m;
  path.points.back().yaw_rad = std::atan2(along_m.y(), along_m.x());
}

PlanResult explainFailure(const NavigationGrid& grid, const PlaceRouter& router,
                          const RoomyEnd& start, const PathGoals& goals,
                          const PlannerConfig& config, double radius_m) {
  const RoomyEnd& end = goals.ends.front();
  const Eigen::Vector3d end_m = grid.computePosition(end.node);
  const Blockage blockage = findBlockage(grid, router, start.node, end_m, radius_m);
  const auto starts = findJoins(grid, router, start, 0, radius_m, config.join_distance_m);
  const auto exits = findJoins(grid, router, end, 0, radius_m, config.join_distance_m);
  const bool has_route = router.findRoute(starts, exits, end_m, 2.0, radius_m).has_value();
  PlanResult result = fail(PlanStatus::kNoWay, describe(blockage));
  if (has_route) result.message += "; the places know a way, but the ground plan is not free there";
  result.blockage = blockage;
  return result;
}

PlanResult makeResult(const NavigationGrid& grid, const PathStart& start, const PathGoals& goals,
                      const PathDraft& draft, double spacing_m) {
  PlanResult result;
  result.status = PlanStatus::kFound;
  Waypoints waypoints = start.escape;
  waypoints.insert(waypoints.end(), draft.waypoints.begin(), draft.waypoints.end());
  result.path = drawPath(grid, waypoints, spacing_m);
  result.path.places = draft.places;
  result.path.has_view = goals.ends[draft.goal].has_view;
  result.message = joinMessages(start.message, goals.message);
  return result;
}

/// Places nearest to a point, with no look at what is between.
std::vector<PlaceRouter::Join> joinBlindly(const PlaceRouter& router, const Eigen::Vector3d& p_m,
                                           double max_distance_m) {
  constexpr std::size_t kMaxJoins = 3;
  std::vector<PlaceRouter::Join> joins;
  for (const std::size_t place : router.findNear(p_m, max_distance_m)) {
    joins.push_back({place, (router.position(place) - p_m).norm(), 0});
    if (joins.size() == kMaxJoins) break;
  }
  return joins;
}

Path drawRoute(const PlaceRouter& router, const PlaceRouter::Route& route,
               const std::vector<Eigen::Vector3d>& corners_m) {
  Path path;
  path.least_clearance_m = route.clearance_m;
  for (std::size_t i = 0; i < corners_m.size(); ++i) {
    path.points.push_back({corners_m[i], 0.0});
    if (i == 0) continue;
    const Eigen::Vector3d along_m = corners_m[i] - corners_m[i - 1];
    path.length_m += along_m.norm();
    path.points[i - 1].yaw_rad = std::atan2(along_m.y(), along_m.x());
    path.points[i].yaw_rad = path.points[i - 1].yaw_rad;
  }
  for (const std::size_t place : route.places) path.places.push_back(router.id(place));
  return path;
}

}  // namespace

Planner::Planner(const PlaceGraph& places, const places::GroundPlan& plan,
                 const PlannerConfig& config)
    : config_((config::validate(config, "planner"), config)),
      router_(std::make_shared<PlaceRouter>(places)),
      grid_(std::make_shared<NavigationGrid>(plan, config.max_step_m)) {}

PlanResult Planner::plan(const PlanRequest& request) const {
  const std::string problem = findProblem(request);
  if (!problem.empty()) return fail(PlanStatus::kInvalid, problem);
  if (grid_->numTiles() > 0) return planOnGrid(request);
  if (router_->size() > 0) return planOverPlaces(request);
  return fail(PlanStatus::kNoMap, "the map holds no places and no ground plan yet");
}

PlanResult Planner::planOnGrid(const PlanRequest& request) const {
  const double radius_m = request.robot_radius_m;
  const PathStart start = findStart(*grid_, request, config_);
  if (start.status != PlanStatus::kFound) return fail(start.status, start.message);
  const auto& object = request.goal.object;
  PathGoals goals =
      object ? findStandingPoints(*grid_, *object, radius_m, config_, StandingPoints::kBest)
             : findPointGoal(*grid_, request.goal.position_m, radius_m, config_);
  if (goals.status != PlanStatus::kFound) return fail(goals.status, goals.message);
  auto draft = findDraft(*grid_, *router_, start.end, goals, radius_m, config_);
  if (!draft && object) {
    goals = findStandingPoints(*grid_, *object, radius_m, config_, StandingPoints::kAll);
    draft = findDraft(*grid_, *router_, start.end, goals, radius_m, config_);
  }
  if (!draft) return explainFailure(*grid_, *router_, start.end, goals, config_, radius_m);
  PlanResult result = makeResult(*grid_, start, goals, *draft, config_.spacing_m);
  if (object) lookAt(object->center_m, result.path);
  return result;
}

PlanResult Planner::planOverPlaces(const PlanRequest& request) const {
  const auto& object = request.goal.object;
  const Eigen::Vector3d goal_m = object ? object->center_m : request.goal.position_m;
  const auto starts = joinBlindly(*router_, request.start_m, config_.join_distance_m);
  const auto goals = joinBlindly(*router_, goal_m, config_.join_distance_m);
  const std::string none = "no place is within " + std::to_string(config_.join_distance_m) +
                           " m (join_distance_m) of the ";
  if (starts.empty()) return fail(PlanStatus::kStartOutside, none + "start");
  if (goals.empty()) return fail(PlanStatus::kGoalOutside, none + "goal");
  const auto route = router_->findRoute(starts, goals, goal_m, 0.0, request.robot_radius_m);
  PlanResult result;
  if (!route) {
    Blockage blockage;
    setLastPlace(*router_, router_->findReached(starts, request.robot_radius_m), goal_m, blockage);
    blockage.position_m = blockage.last_m;
    result = fail(PlanStatus::kNoWay, describe(blockage));
    result.blockage = blockage;
    return result;
  }
  std::vector<Eigen::Vector3d> corners_m{request.start_m};
  for (const std::size_t place : route->places) corners_m.push_back(router_->position(place));
  if (!object) corners_m.push_back(goal_m);
  result.status = PlanStatus::kFound;
  result.message = "there is no ground plan: the path leads from place to place";
  result.path = drawRoute(*router_, *route, corners_m);
  if (object) lookAt(goal_m, result.path);
  return result;
}

}  // namespace tsg::planning
