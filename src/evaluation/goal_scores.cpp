// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/goal_scores.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "agreement.h"
#include "median.h"
#include "task_scene_graph/planning/planner.h"

namespace tsg::evaluation {
namespace {

using planning::Planner;
using planning::PlannerConfig;
using planning::PlanRequest;
using planning::PlanResult;

/// How far a path of the map may lie above or below the true floor of the same storey.
constexpr double kMaxOffFloor_m = 0.5;

/// The upright box that holds a box, turned as far about z as its longest level side is.
OrientedBox toUpright(const RotatedBox& box) {
  Eigen::Index longest = 0;
  double longest_m = -1.0;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double level_m = box.size_m[axis] * box.rotation.col(axis).head<2>().norm();
    if (level_m > longest_m) longest = axis;
    longest_m = std::max(longest_m, level_m);
  }
  const Eigen::Vector3d along = box.rotation.col(longest);
  OrientedBox upright;
  upright.center_m = box.center_m;
  upright.yaw_rad = std::atan2(along.y(), along.x());
  const Eigen::Matrix3d turned = upright.rotation().transpose() * box.rotation;
  upright.size_m = turned.cwiseAbs() * box.size_m;
  return upright;
}

PlanRequest makeRequest(const Eigen::Vector3d& start_m, const RotatedBox& goal, double radius_m) {
  PlanRequest request;
  request.start_m = start_m;
  request.goal.object = toUpright(goal);
  request.robot_radius_m = radius_m;
  return request;
}

/// The true ways of a robot.
class TrueWays {
 public:
  TrueWays(const places::GroundPlan& floor, const PlannerConfig& config,
           const Eigen::Vector3d& start_m)
      : floor_(floor), config_(config), start_m_(start_m), planner_({}, floor, config) {
    PlanRequest request;
    request.start_m = request.goal.position_m = start_m;
    request.robot_radius_m = config.robot_radius_m;
    const PlanResult result = planner_.plan(request);
    if (!result.isFound()) {
      throw std::invalid_argument("in the true floor the robot cannot stand at the start: " +
                                  result.message);
    }
  }

  std::optional<double> findLength(const RotatedBox& thing) const {
    const PlanResult way = planner_.plan(makeRequest(start_m_, thing, config_.robot_radius_m));
    if (!way.isFound()) return std::nullopt;
    return way.path.length_m;
  }

  /// Along a path; 0 where it leaves the free floor.
  double findLeastClearance(const planning::Path& path) const {
    double least_m = std::numeric_limits<double>::infinity();
    for (const planning::PathPoint& point : path.points) {
      const auto* cell = floor_.find(floor_.computeCell(point.position_m.head<2>()),
                                     point.position_m.z(), kMaxOffFloor_m);
      const bool is_free = cell != nullptr && cell->isFree();
      least_m = std::min(least_m, is_free ? static_cast<double>(cell->clearance_m) : 0.0);
    }
    return path.points.empty() ? 0.0 : least_m;
  }

 private:
  const places::GroundPlan& floor_;
  PlannerConfig config_;
  Eigen::Vector3d start_m_;
  Planner planner_;
};

const Estimate* findNearest(const std::vector<Estimate>& estimates, Eigen::Index task) {
  const Estimate* best = nullptr;
  for (const Estimate& estimate : estimates) {
    if (best == nullptr || estimate.cosines[task] > best->cosines[task]) best = &estimate;
  }
  return best;
}

/// The thing that a box stands for: of those that agree with it the one of largest IoU.
const RotatedBox* findThing(const RotatedBox& box, const std::vector<RotatedBox>& things) {
  const RotatedBox* best = nullptr;
  double best_iou = -1.0;
  for (const RotatedBox& thing : things) {
    const double iou = compareBoxes(box, thing).is_relaxed ? computeIou(box, thing) : -1.0;
    if (iou > best_iou) best = &thing;
    best_iou = std::max(best_iou, iou);
  }
  return best;
}

GoalRow judge(const TaskTruth& task, const Estimate* estimate, const Planner& planner,
              const MapWays& map, const TrueWays& ways, const Eigen::Vector3d& start_m) {
  GoalRow row;
  row.task = task.task;
  row.is_reachable =
      std::any_of(task.boxes.begin(), task.boxes.end(),
                  [&](const RotatedBox& thing) { return ways.findLength(thing).has_value(); });
  row.has_object = estimate != nullptr;
  if (estimate == nullptr) return row;
  if (const RotatedBox* thing = findThing(estimate->box, task.boxes)) {
    row.is_right = true;
    row.is_strict = compareBoxes(estimate->box, *thing).is_strict;
    row.shortest_m = ways.findLength(*thing);
  }
  const double radius_m = map.planner.robot_radius_m;
  const PlanResult result = planner.plan(makeRequest(start_m, estimate->box, radius_m));
  row.message = result.message;
  if (!result.isFound()) return row;
  row.has_path = true;
  row.path_m = result.path.length_m;
  row.least_clearance_m = ways.findLeastClearance(result.path);
  row.is_free =
      row.least_clearance_m > 0.0 && row.least_clearance_m >= radius_m - map.plan.cellSize();
  return row;
}

void addUp(GoalScores& scores) {
  std::vector<double> ratios;
  for (const GoalRow& row : scores.rows) {
    if (!row.is_reachable) {
      ++scores.num_unreachable;
      continue;
    }
    ++scores.num_tasks;
    scores.right += row.is_right ? 1.0 : 0.0;
    scores.strict += row.is_strict ? 1.0 : 0.0;
    scores.path += row.has_path ? 1.0 : 0.0;
    scores.free += row.is_free ? 1.0 : 0.0;
    if (!row.isSuccess()) continue;
    scores.success += 1.0;
    if (!row.shortest_m) continue;
    const double longer_m = std::max(row.path_m, *row.shortest_m);
    scores.spl += longer_m > 0.0 ? *row.shortest_m / longer_m : 1.0;
    if (*row.shortest_m > 0.0) ratios.push_back(row.path_m / *row.shortest_m);
  }
  const double count = std::max(1.0, static_cast<double>(scores.num_tasks));
  for (double* share :
       {&scores.right, &scores.strict, &scores.path, &scores.free, &scores.success, &scores.spl}) {
    *share /= count;
  }
  if (ratios.empty()) return;
  scores.median_ratio = *computeMedian(ratios);
  scores.max_ratio = *std::max_element(ratios.begin(), ratios.end());
}

}  // namespace

GoalScores computeGoalScores(const std::vector<TaskTruth>& truth,
                             const std::vector<Estimate>& estimates, const MapWays& map,
                             const places::GroundPlan& true_floor, const Eigen::Vector3d& start_m) {
  for (const Estimate& estimate : estimates) {
    if (static_cast<std::size_t>(estimate.cosines.size()) != truth.size()) {
      throw std::invalid_argument("an object has " + std::to_string(estimate.cosines.size()) +
                                  " cosines, expected one for each of the " +
                                  std::to_string(truth.size()) + " tasks");
    }
  }
  if (map.places.places.empty() && map.plan.tiles().empty()) {
    throw std::invalid_argument("the map holds neither places nor a ground plan to go by");
  }
  PlannerConfig whole = map.planner;
  whole.max_search_cells = 100000000;
  const TrueWays ways(true_floor, whole, start_m);
  const Planner planner(map.places, map.plan, map.planner);
  GoalScores scores;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i].boxes.empty()) continue;
    const Estimate* estimate = findNearest(estimates, static_cast<Eigen::Index>(i));
    scores.rows.push_back(judge(truth[i], estimate, planner, map, ways, start_m));
  }
  addUp(scores);
  return scores;
}

}  // namespace tsg::evaluation
