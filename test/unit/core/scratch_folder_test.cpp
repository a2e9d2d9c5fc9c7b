// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/scratch_folder.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <set>
#include <stdexcept>

#include "support.h"

namespace tsg {
namespace {
namespace fs = std::filesystem;

std::set<fs::path> list(const fs::path& folder) {
  return {fs::directory_iterator(folder), fs::directory_iterator{}};
}

TEST(ScratchFolder, GoesWithItsOwnerAndAllThatIsInIt) {
  const test::TemporaryFolder parent;
  {
    const ScratchFolder scratch(parent.path());
    fs::create_directories(scratch.path() / "map" / "state");
    std::ofstream(scratch.path() / "map" / "state" / "tasks.bin") << "x";
    const ScratchFolder other(parent.path());
    EXPECT_EQ(list(parent.path()), (std::set<fs::path>{scratch.path(), other.path()}));
  }
  EXPECT_TRUE(list(parent.path()).empty());
}

TEST(ScratchFolder, OfAProcessThatWasKilledIsRemovedByTheNext) {
  const test::TemporaryFolder parent;
  const pid_t child = fork();
  if (child == 0) {
    const ScratchFolder scratch(parent.path());
    std::ofstream(scratch.path() / "half a map") << "x";
    kill(getpid(), SIGKILL);
  }
  waitpid(child, nullptr, 0);
  ASSERT_EQ(list(parent.path()).size(), 1U);
  const ScratchFolder next(parent.path());
  EXPECT_EQ(list(parent.path()), std::set<fs::path>{next.path()});
}

TEST(ScratchFolder, WhatOthersMadeIsLeftAlone) {
  const test::TemporaryFolder parent;
  const std::set<fs::path> others = {parent.path() / "task_scene_graph_map",
                                     parent.path() / "task_scene_graph_999999",
                                     parent.path() / "task_scene_graph_999999_notours",
                                     parent.path() / "task_scene_graph__abcdef"};
  for (const auto& other : others) fs::create_directory(other);
  { const ScratchFolder scratch(parent.path()); }
  EXPECT_EQ(list(parent.path()), others);
}

TEST(ScratchFolder, WhereNoneCanBeMadeIsNamed) {
  const test::TemporaryFolder parent;
  const fs::path absent = parent.path() / "absent";
  try {
    const ScratchFolder scratch(absent);
    FAIL() << "made " << scratch.path();
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find(absent.string() + "': No such file"), std::string::npos)
        << e.what();
  }
}

}  // namespace
}  // namespace tsg
