// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "task_scene_graph/scene_graph/tasks.h"

namespace tsg::scene_graph {

/// A change of the tasks in force, as a user asks for it while the map grows.
struct TaskChange {
  enum class Action {
    kSet,     ///< the tasks become `tasks`, in that order
    kAdd,     ///< `tasks` are appended; none of them is in force yet
    kRemove,  ///< the tasks with the names of `tasks` go; the others keep their order
    kRename   ///< the tasks with the names of `tasks` get `new_names`; what they look for stays
  };

  Action action = Action::kSet;
  TaskList tasks;                      ///< kSet and kAdd: with an embedding each; else names alone
  std::vector<std::string> new_names;  ///< kRename: one for each task
};

/// The tasks after a change. All of it or nothing: what is wrong with any part of it is said of
/// all.
/// @throws config::ConfigError naming each task that is unknown, in force already, there twice,
/// empty, not UTF-8 or too long, and each embedding that is missing, not finite, zero or of a size
/// other than those in force. O(tasks^2).
TaskList applyChange(const TaskList& before, const TaskChange& change);

}  // namespace tsg::scene_graph
