// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/task_changes.h"

#include <algorithm>

#include "task_scene_graph/config/config.h"

namespace tsg::scene_graph {
namespace {

using Violations = std::vector<std::string>;

std::size_t findTask(const TaskList& tasks, const std::string& name) {
  return static_cast<std::size_t>(std::find(tasks.names.begin(), tasks.names.end(), name) -
                                  tasks.names.begin());
}

bool hasTask(const TaskList& tasks, const std::string& name) {
  return findTask(tasks, name) < tasks.size();
}

std::string listNames(const TaskList& tasks) {
  std::string list;
  for (const auto& name : tasks.names) list += (list.empty() ? "'" : ", '") + name + "'";
  return list.empty() ? "there is none" : "there are " + list;
}

void requireKnown(const TaskList& before, const TaskList& named, Violations& violations) {
  for (const auto& name : named.names) {
    if (hasTask(before, name)) continue;
    violations.push_back("no task '" + name + "', " + listNames(before));
  }
}

/// Rows of `a`, then of `b`; the one that has rows where the other has none.
EmbeddingMatrix appendRows(const EmbeddingMatrix& a, const EmbeddingMatrix& b) {
  if (a.rows() == 0) return b;
  if (b.rows() == 0) return a;
  EmbeddingMatrix all(a.rows() + b.rows(), a.cols());
  all << a, b;
  return all;
}

TaskList addTasks(const TaskList& before, const TaskList& added, Violations& violations) {
  for (const auto& name : added.names) {
    if (hasTask(before, name)) violations.push_back("task '" + name + "' is in force already");
  }
  if (before.hasEmbeddings() && added.hasEmbeddings() &&
      before.embeddings.cols() != added.embeddings.cols()) {
    violations.push_back("embeddings of " + std::to_string(added.embeddings.cols()) +
                         " numbers, expected " + std::to_string(before.embeddings.cols()) +
                         " as those in force have");
  }
  if (!violations.empty()) return before;
  TaskList after = before;
  after.names.insert(after.names.end(), added.names.begin(), added.names.end());
  after.embeddings = appendRows(before.embeddings, added.embeddings);
  return after;
}

TaskList removeTasks(const TaskList& before, const TaskList& removed, Violations& violations) {
  requireKnown(before, removed, violations);
  std::vector<Eigen::Index> rows;
  TaskList after;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (hasTask(removed, before.names[i])) continue;
    after.names.push_back(before.names[i]);
    rows.push_back(static_cast<Eigen::Index>(i));
  }
  if (!before.hasEmbeddings()) return after;
  after.embeddings.resize(static_cast<Eigen::Index>(rows.size()), before.embeddings.cols());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    after.embeddings.row(static_cast<Eigen::Index>(i)) = before.embeddings.row(rows[i]);
  }
  return after;
}

TaskList renameTasks(const TaskList& before, const TaskChange& change, Violations& violations) {
  requireKnown(before, change.tasks, violations);
  if (change.new_names.size() != change.tasks.size()) {
    violations.push_back(std::to_string(change.new_names.size()) + " new names for " +
                         std::to_string(change.tasks.size()) + " tasks, expected one for each");
  }
  if (!violations.empty()) return before;
  TaskList after = before;
  for (std::size_t i = 0; i < change.tasks.size(); ++i) {
    after.names[findTask(before, change.tasks.names[i])] = change.new_names[i];
  }
  return after;
}

TaskList applyUnchecked(const TaskList& before, const TaskChange& change, Violations& violations) {
  switch (change.action) {
    case TaskChange::Action::kSet:
      return change.tasks;
    case TaskChange::Action::kAdd:
      return addTasks(before, change.tasks, violations);
    case TaskChange::Action::kRemove:
      return removeTasks(before, change.tasks, violations);
    case TaskChange::Action::kRename:
      return renameTasks(before, change, violations);
  }
  return before;
}

}  // namespace

TaskList applyChange(const TaskList& before, const TaskChange& change) {
  using Action = TaskChange::Action;
  const std::string where = "change of the tasks";
  Violations violations;
  if (change.action == Action::kSet || change.action == Action::kAdd) {
    checkClusterable(change.tasks, where, 0);
  }
  if (change.action != Action::kSet && change.tasks.size() == 0) {
    violations.push_back("no task is named, expected at least one");
  }
  TaskList after = applyUnchecked(before, change, violations);
  if (!violations.empty()) throw config::ConfigError(where, violations);
  after.validate(where);
  return after;
}

}  // namespace tsg::scene_graph
