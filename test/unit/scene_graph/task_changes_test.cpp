// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/task_changes.h"

#include <gtest/gtest.h>

#include <limits>

#include "task_scene_graph/config/config.h"

namespace tsg::scene_graph {
namespace {

using Action = TaskChange::Action;
using Names = std::vector<std::string>;

/// Tasks with embeddings of their own: row i is (1, first letter of the name).
TaskList makeTasks(const Names& names) {
  TaskList tasks;
  tasks.names = names;
  tasks.embeddings.resize(static_cast<Eigen::Index>(names.size()), 2);
  for (std::size_t i = 0; i < names.size(); ++i) {
    tasks.embeddings.row(static_cast<Eigen::Index>(i)) << 1.0F, static_cast<float>(names[i][0]);
  }
  return tasks;
}

TaskChange makeChange(Action action, const TaskList& tasks, const Names& new_names = {}) {
  return {action, tasks, new_names};
}

TaskList namesOnly(const Names& names) {
  TaskList tasks;
  tasks.names = names;
  return tasks;
}

std::string findError(const TaskList& before, const TaskChange& change) {
  try {
    applyChange(before, change);
  } catch (const config::ConfigError& e) {
    return e.what();
  }
  return "";
}

void expectContains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' in: " << text;
}

const TaskList kBefore = makeTasks({"mug", "book", "lamp"});

TEST(TaskChange, SetReplacesAll) {
  EXPECT_EQ(applyChange(kBefore, makeChange(Action::kSet, makeTasks({"sofa"}))),
            makeTasks({"sofa"}));
  EXPECT_EQ(applyChange(kBefore, makeChange(Action::kSet, {})).size(), 0U);
}

TEST(TaskChange, AddAppends) {
  const auto after = applyChange(kBefore, makeChange(Action::kAdd, makeTasks({"cup", "pan"})));
  EXPECT_EQ(after, makeTasks({"mug", "book", "lamp", "cup", "pan"}));
  EXPECT_EQ(applyChange({}, makeChange(Action::kAdd, makeTasks({"cup"}))), makeTasks({"cup"}));
}

TEST(TaskChange, RemoveKeepsTheOrderAndTheEmbeddingsOfTheOthers) {
  EXPECT_EQ(applyChange(kBefore, makeChange(Action::kRemove, namesOnly({"book"}))),
            makeTasks({"mug", "lamp"}));
  EXPECT_EQ(
      applyChange(kBefore, makeChange(Action::kRemove, namesOnly({"lamp", "mug", "book"}))).size(),
      0U);
}

TEST(TaskChange, RenameKeepsWhatATaskLooksFor) {
  const auto after =
      applyChange(kBefore, makeChange(Action::kRename, namesOnly({"book"}), {"novel"}));
  EXPECT_EQ(after.names, (Names{"mug", "novel", "lamp"}));
  EXPECT_EQ(after.embeddings, kBefore.embeddings);
}

TEST(TaskChange, NamesCanBeSwapped) {
  const auto after = applyChange(
      kBefore, makeChange(Action::kRename, namesOnly({"mug", "lamp"}), {"lamp", "mug"}));
  EXPECT_EQ(after.names, (Names{"lamp", "book", "mug"}));
}

TEST(TaskChange, UnknownTasksAreNamedBesideThoseInForce) {
  const auto error = findError(kBefore, makeChange(Action::kRemove, namesOnly({"pen", "mug"})));
  expectContains(error, "no task 'pen', there are 'mug', 'book', 'lamp'");
  EXPECT_EQ(error.find("no task 'mug'"), std::string::npos);
  expectContains(findError({}, makeChange(Action::kRename, namesOnly({"pen"}), {"ink"})),
                 "no task 'pen', there is none");
}

TEST(TaskChange, WhatIsInForceCannotBeAdded) {
  expectContains(findError(kBefore, makeChange(Action::kAdd, makeTasks({"mug"}))),
                 "task 'mug' is in force already");
}

TEST(TaskChange, RenamingOntoAnotherTaskIsRefused) {
  expectContains(findError(kBefore, makeChange(Action::kRename, namesOnly({"mug"}), {"book"})),
                 "'book' is there twice");
}

TEST(TaskChange, EachTaskNeedsItsNewName) {
  expectContains(findError(kBefore, makeChange(Action::kRename, namesOnly({"mug"}))),
                 "0 new names for 1 tasks");
}

TEST(TaskChange, NothingToDoIsSaid) {
  for (const Action action : {Action::kAdd, Action::kRemove, Action::kRename}) {
    expectContains(findError(kBefore, makeChange(action, {})), "no task is named");
  }
}

TEST(TaskChange, BadNamesAndEmbeddingsAreRefused) {
  TaskList wide = makeTasks({"cup"});
  wide.embeddings.conservativeResize(1, 3);
  wide.embeddings(0, 2) = 1.0F;
  expectContains(findError(kBefore, makeChange(Action::kAdd, wide)), "embeddings of 3 numbers");
  TaskList broken = makeTasks({"cup"});
  broken.embeddings(0, 1) = std::numeric_limits<float>::quiet_NaN();
  expectContains(findError(kBefore, makeChange(Action::kAdd, broken)), "NaN");
  expectContains(findError(kBefore, makeChange(Action::kAdd, namesOnly({"cup"}))),
                 "expected an embedding");
  TaskList empty = makeTasks({"cup"});
  empty.names = {" "};
  expectContains(findError(kBefore, makeChange(Action::kAdd, empty)), "is empty");
  TaskList invalid = makeTasks({"cup"});
  invalid.names = {"c\xff"};
  expectContains(findError(kBefore, makeChange(Action::kSet, invalid)), "not valid UTF-8");
  TaskList twice = makeTasks({"cup", "cup"});
  expectContains(findError(kBefore, makeChange(Action::kSet, twice)), "is there twice");
  TaskList long_one = makeTasks({"cup"});
  long_one.names = {std::string(10240, 'a')};
  expectContains(findError(kBefore, makeChange(Action::kSet, long_one)), "a name of 10240 bytes");
}

}  // namespace
}  // namespace tsg::scene_graph
