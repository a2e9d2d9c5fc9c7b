// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/files.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <stdexcept>

#include "support.h"
#include "task_scene_graph/core/stage_times.h"

namespace tsg {
namespace {
namespace fs = std::filesystem;

std::string readFile(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

std::size_t countFiles(const fs::path& folder) {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator{}));
}

TEST(AtomicFile, ParentFoldersAreMadeAndNoTemporaryFileStays) {
  const test::TemporaryFolder folder;
  const fs::path path = folder.path() / "a" / "b.txt";
  writeFileAtomically(path, [](std::ostream& out) { out << "hello"; });
  EXPECT_EQ(readFile(path), "hello");
  EXPECT_EQ(countFiles(path.parent_path()), 1U);
}

TEST(AtomicFile, AFailedWriteLeavesTheOldFile) {
  const test::TemporaryFolder folder;
  const fs::path path = folder.path() / "map.json";
  writeFileAtomically(path, [](std::ostream& out) { out << "old"; });
  const auto failing = [](std::ostream& out) {
    out << "half";
    throw std::runtime_error("no more");
  };
  EXPECT_THROW(writeFileAtomically(path, failing), std::runtime_error);
  EXPECT_EQ(readFile(path), "old");
  EXPECT_EQ(countFiles(folder.path()), 1U);
}

TEST(AtomicFile, ErrorNamesThePath) {
  try {
    writeFileAtomically("/proc/no_such_folder/x.json", [](std::ostream&) {});
    FAIL() << "expected an exception";
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("/proc/no_such_folder/x.json"), std::string::npos);
  }
}

TEST(StageTimesType, QuantilesAreOfTheNearestRank) {
  StageTimes times;
  for (int i = 1; i <= 100; ++i) times.add("stage", i);
  const TimeSummary summary = times.summarize().at("stage");
  EXPECT_EQ(summary.count, 100U);
  EXPECT_DOUBLE_EQ(summary.mean_ms, 50.5);
  EXPECT_DOUBLE_EQ(summary.p50_ms, 50.0);
  EXPECT_DOUBLE_EQ(summary.p95_ms, 95.0);
  EXPECT_DOUBLE_EQ(summary.max_ms, 100.0);
}

TEST(StageTimesType, MeasureReturnsWhatTheActionReturns) {
  StageTimes times;
  EXPECT_EQ(times.measure("x", [] { return 7; }), 7);
  EXPECT_EQ(times.summarize().at("x").count, 1U);
}

}  // namespace
}  // namespace tsg
