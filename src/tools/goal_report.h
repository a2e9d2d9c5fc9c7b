// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "saved_map.h"
#include "task_scene_graph/evaluation/goal_scores.h"
#include "task_scene_graph/evaluation/true_floor.h"
#include "task_scene_graph/map/files.h"
#include "task_scene_graph/map/settings.h"
#include "task_scene_graph/places/places_config.h"

/// What evaluate_scene_graph says about going to things.
namespace tsg::tools {

struct GoalInputs {
  std::string map;   ///< folder
  std::string mesh;  ///< true surfaces, PLY
};

/// The walk's first pose: where a robot would be when the map is used again.
inline Eigen::Vector3d findWalkStart(const map::Map& map, const std::string& folder) {
  if (map.trajectory()->isEmpty()) {
    throw std::invalid_argument("map '" + folder +
                                "' has no trajectory; --true-mesh needs where the walk began");
  }
  return map.trajectory()->poses().begin()->second.translation();
}

inline evaluation::GoalScores scoreGoals(const GoalInputs& inputs,
                                         const std::vector<evaluation::TaskTruth>& truth,
                                         const std::vector<evaluation::Estimate>& estimates) {
  if (!std::filesystem::is_directory(inputs.map)) {
    throw std::invalid_argument("map '" + inputs.map +
                                "' is no folder; --true-mesh needs a map folder with places");
  }
  const map::Map map = loadMap(inputs.map);
  const auto places = map::readSettings<places::PlacesConfig>(inputs.map, "mesh_fusion", "places");
  evaluation::MapWays ways{
      *map.places(), map.placeMemory()->plan,
      map::readSettings<planning::PlannerConfig>(inputs.map, "mesh_fusion", "planner")};
  ways.planner.max_step_m = places.max_step_m;
  evaluation::TrueFloorConfig config;
  config.body_height_m = places.body_height_m;
  config.max_step_m = places.max_step_m;
  const Eigen::Vector3d start_m = findWalkStart(map, inputs.map);
  const auto floor =
      evaluation::computeTrueFloor(evaluation::loadTrueMesh(inputs.mesh), start_m, config);
  return evaluation::computeGoalScores(truth, estimates, ways, floor, start_m);
}

inline const char* describeGoal(const evaluation::GoalRow& row) {
  if (!row.is_reachable) return "no true way to any";
  if (!row.has_object) return "no object";
  if (!row.is_right) return "wrong object";
  if (!row.has_path) return "no path";
  return row.is_free ? "there" : "path meets an obstacle";
}

inline void printGoals(const evaluation::GoalScores& scores) {
  std::printf("\n%-32s %-24s %7s %9s %9s\n", "go to", "", "path", "shortest", "clearance");
  for (const evaluation::GoalRow& row : scores.rows) {
    std::printf("%-32.32s %-24s %7.2f %9.2f %9.2f  %s\n", row.task.c_str(), describeGoal(row),
                row.path_m, row.shortest_m.value_or(0.0), row.least_clearance_m,
                row.has_path ? "" : row.message.c_str());
  }
  std::printf(
      "  success %.3f of %zu tasks (%zu more have no true way): right object %.3f (strict %.3f), "
      "path %.3f, free %.3f\n  path over shortest way: median %.3f, largest %.3f; SPL %.3f\n",
      scores.success, scores.num_tasks, scores.num_unreachable, scores.right, scores.strict,
      scores.path, scores.free, scores.median_ratio, scores.max_ratio, scores.spl);
}

inline nlohmann::json toJson(const evaluation::GoalRow& row) {
  nlohmann::json json = {{"task", row.task},         {"is_reachable", row.is_reachable},
                         {"is_right", row.is_right}, {"is_strict", row.is_strict},
                         {"has_path", row.has_path}, {"is_free", row.is_free},
                         {"path_m", row.path_m},     {"least_clearance_m", row.least_clearance_m},
                         {"message", row.message}};
  json["shortest_m"] = row.shortest_m ? nlohmann::json(*row.shortest_m) : nlohmann::json();
  return json;
}

/// Prints the scores and returns them.
inline nlohmann::json reportGoals(const GoalInputs& inputs,
                                  const std::vector<evaluation::TaskTruth>& truth,
                                  const std::vector<evaluation::Estimate>& estimates) {
  const evaluation::GoalScores scores = scoreGoals(inputs, truth, estimates);
  printGoals(scores);
  nlohmann::json rows = nlohmann::json::array();
  for (const evaluation::GoalRow& row : scores.rows) rows.push_back(toJson(row));
  return {{"num_tasks", scores.num_tasks},
          {"num_unreachable", scores.num_unreachable},
          {"right", scores.right},
          {"strict", scores.strict},
          {"path", scores.path},
          {"free", scores.free},
          {"success", scores.success},
          {"spl", scores.spl},
          {"median_ratio", scores.median_ratio},
          {"max_ratio", scores.max_ratio},
          {"tasks", rows}};
}

}  // namespace tsg::tools
