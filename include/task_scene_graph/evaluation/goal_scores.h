// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/evaluation/object_scores.h"
#include "task_scene_graph/places/ground_plan.h"
#include "task_scene_graph/planning/planner_config.h"

/// Whether a robot that is sent to the thing of a task gets there with a map.
namespace tsg::evaluation {

/// What a map knows about ways: what planning::Planner takes.
struct MapWays {
  PlaceGraph places;
  places::GroundPlan plan;
  planning::PlannerConfig planner;  ///< and the robot's radius
};

/// What became of one task.
struct GoalRow {
  std::string task;
  /// A way to one of its things exists in the true floor. Only such tasks count.
  bool is_reachable = false;
  bool has_object = false;  ///< the map has any object
  bool is_right = false;    ///< the object of highest cosine and a thing of the task agree: relaxed
  bool is_strict = false;   ///< ... strictly, see ObjectScores
  bool has_path = false;    ///< the map's planner finds a way to that object
  bool is_free = false;     ///< ... that has room in the true floor as well
  double path_m = 0.0;      ///< length of that way
  double least_clearance_m = 0.0;    ///< along it, to the nearest true obstacle; 0: it meets one
  std::optional<double> shortest_m;  ///< true way to the thing that the object stands for
  std::string message;               ///< the planner's, for people

  bool isSuccess() const { return is_reachable && is_right && has_path && is_free; }
};

/// Shares are of the tasks that count (`num_tasks`), in [0, 1]; 0 if none does.
struct GoalScores {
  std::size_t num_tasks = 0;
  std::size_t num_unreachable = 0;  ///< tasks with things to none of which a true way leads
  double right = 0.0;
  double strict = 0.0;
  double path = 0.0;     ///< to whatever object
  double free = 0.0;     ///< likewise
  double success = 0.0;  ///< right object, a path to it, and that free
  /// Success weighted by path length: mean of shortest / max(path, shortest) over the successes,
  /// 0 for the others [Anderson18].
  double spl = 0.0;
  /// Path over shortest way, of the successes; 0 if there is none. Below 1 where the map's box lies
  /// nearer than the thing, or its free space reaches farther than the true one.
  double median_ratio = 0.0;
  double max_ratio = 0.0;
  std::vector<GoalRow> rows;  ///< of each task with things
};

/// For each task with things: the estimate of highest cosine (the first among equals) is what the
/// robot is sent to, by the map's own planner, as the service plan_path does. Right: the box holds
/// the centre of one of the task's things or that thing its centre. Free: at every point of the
/// path (planner.spacing_m apart) the true floor of that storey (at most 0.5 m above or below: on
/// stairs the map knows the slope, not the steps) has the robot's radius less one cell of the map's
/// ground plan. The true shortest way is the same planner's in the true floor, which looks at all
/// of its cells, to the thing that the object stands for (of several the one of largest IoU).
/// @param start_m  world; where the robot is
/// @throws std::invalid_argument if estimates have not a cosine for each task, the robot has no
/// room at the start in the true floor, or the map neither places nor a ground plan.
/// O(tasks * (estimates + cells log cells)).
GoalScores computeGoalScores(const std::vector<TaskTruth>& truth,
                             const std::vector<Estimate>& estimates, const MapWays& map,
                             const places::GroundPlan& true_floor, const Eigen::Vector3d& start_m);

}  // namespace tsg::evaluation
