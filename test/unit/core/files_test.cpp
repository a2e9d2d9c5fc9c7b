// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/files.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <functional>
#include <optional>
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

/// Of a process that has just ended.
pid_t findDeadProcess() {
  const pid_t pid = fork();
  if (pid == 0) _exit(0);
  waitpid(pid, nullptr, 0);
  return pid;
}

TEST(AtomicFile, TemporaryFilesOfDeadProcessesAreRemovedAtTheNextWrite) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "map.json";
  const auto left = [&](const std::string& ending) {
    std::ofstream(path.string() + ending) << "left";
    return path.string() + ending;
  };
  const std::string of_dead = left(".tmp" + std::to_string(findDeadProcess()));
  const std::vector<std::string> kept = {left(".tmp1"), left(".tmp"), left(".tmpx"),
                                         left(".tmp99999999999999999999")};
  const auto of_other = folder.path() / ("other.json.tmp" + std::to_string(findDeadProcess()));
  std::ofstream(of_other) << "left";
  writeFileAtomically(path, [](std::ostream& out) { out << "new"; });
  EXPECT_FALSE(fs::exists(of_dead));
  for (const auto& name : kept) EXPECT_TRUE(fs::exists(name)) << name;
  EXPECT_TRUE(fs::exists(of_other));
}

TEST(AtomicFile, ErrorNamesThePath) {
  try {
    writeFileAtomically("/proc/no_such_folder/x.json", [](std::ostream&) {});
    FAIL() << "expected an exception";
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("/proc/no_such_folder/x.json"), std::string::npos);
  }
}

std::string errorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::exception& e) {
    return e.what();
  }
  return "";
}

TEST(RequireFile, MessageHasTheFullPathAndWhatIsWrong) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(errorOf([] { requireFile("task file", "no_such.yaml"); }),
            "task file '" + (fs::current_path() / "no_such.yaml").string() + "' is not there");
  EXPECT_EQ(errorOf([&] { requireFile("task file", folder.path()); }),
            "task file '" + folder.path().string() + "' is a folder, expected a file");
  std::ofstream(folder.path() / "x.yaml") << "x";
  EXPECT_EQ(errorOf([&] { requireFile("task file", folder.path() / "x.yaml"); }), "");
}

/// Sets an environment variable for one test; null: unset.
class Variable {
 public:
  Variable(const char* name, const char* value) : name_(name) {
    const char* old = std::getenv(name);
    if (old != nullptr) old_ = old;
    value == nullptr ? unsetenv(name) : setenv(name, value, 1);
  }
  ~Variable() { old_ ? setenv(name_, old_->c_str(), 1) : unsetenv(name_); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> old_;
};

TEST(ExpandPath, TildeIsTheHomeFolderAtTheBeginningOnly) {
  const Variable home("HOME", "/home/somebody");
  EXPECT_EQ(expandPath("~"), "/home/somebody");
  EXPECT_EQ(expandPath("~/map"), "/home/somebody/map");
  EXPECT_EQ(expandPath("~/a/../map/"), "/home/somebody/map");
  EXPECT_EQ(expandPath("/data/~/map"), "/data/~/map");
  EXPECT_EQ(expandPath("x~", "/data"), "/data/x~");
}

TEST(ExpandPath, WithoutHomeTheUsersOwnFolderIsLookedUp) {
  const Variable home("HOME", nullptr);
  const fs::path path = expandPath("~/map");
  EXPECT_TRUE(path.is_absolute());
  EXPECT_EQ(path.string().find('~'), std::string::npos);
}

TEST(ExpandPath, TildeAndANameIsThatUsersFolder) {
  EXPECT_EQ(expandPath("~root/map"), "/root/map");
  EXPECT_NE(errorOf([] {
              expandPath("~no_such_user_here/map");
            }).find("there is no user 'no_such_user_here'"),
            std::string::npos);
}

TEST(ExpandPath, VariablesAreReplaced) {
  const Variable variable("TSG_TEST_FOLDER", "/data/maps");
  EXPECT_EQ(expandPath("$TSG_TEST_FOLDER/a"), "/data/maps/a");
  EXPECT_EQ(expandPath("${TSG_TEST_FOLDER}_old/a"), "/data/maps_old/a");
  EXPECT_EQ(expandPath("/x/$5/a$"), "/x/$5/a$");  // no names of variables
}

TEST(ExpandPath, AVariableThatIsNotSetIsNamed) {
  const Variable variable("TSG_TEST_FOLDER", nullptr);
  EXPECT_EQ(errorOf([] { expandPath("$TSG_TEST_FOLDER/a"); }),
            "path '$TSG_TEST_FOLDER/a': the environment variable 'TSG_TEST_FOLDER' is not set");
  EXPECT_NE(errorOf([] { expandPath("${TSG_TEST_FOLDER"); }).find("not closed"), std::string::npos);
}

TEST(ExpandPath, FileSchemeIsTakenOffAndOthersAreRefused) {
  const Variable home("HOME", "/home/somebody");
  EXPECT_EQ(expandPath("file:///data/my%20map"), "/data/my map");
  EXPECT_EQ(expandPath("file://localhost/data/map"), "/data/map");
  EXPECT_EQ(expandPath("file://~/map"), "/home/somebody/map");
  EXPECT_EQ(expandPath("/data/100%25"), "/data/100%25");
  EXPECT_NE(errorOf([] { expandPath("package://maps/a"); }).find("not 'package://'"),
            std::string::npos);
  EXPECT_NE(errorOf([] { expandPath("$(find maps)/a"); }).find("launch files only"),
            std::string::npos);
}

TEST(ExpandPath, RelativePathsBeginAtTheFolder) {
  EXPECT_EQ(expandPath("map", "/data"), "/data/map");
  EXPECT_EQ(expandPath("../map", "/data/config"), "/data/map");
  EXPECT_EQ(expandPath("./map/."), fs::current_path() / "map");
  EXPECT_EQ(expandPath("/map", "/data"), "/map");
  EXPECT_EQ(expandPath("/", "/data"), "/");
  EXPECT_EQ(expandPath("", "/data"), "");
}

TEST(WrittenFiles, OneLineSaysWhichAndWhatTheyHold) {
  EXPECT_EQ(describeWritten("/home/u/map", {{"mesh.ply", "3 vertices"}, {"settings.yaml", ""}}),
            "wrote /home/u/map: mesh.ply (3 vertices), settings.yaml");
  EXPECT_EQ(describeWritten({}, {{"/x/tasks.yaml", "1 task"}}), "wrote /x/tasks.yaml (1 task)");
}

TEST(WrittenFiles, CountsAgreeWithTheirNouns) {
  EXPECT_EQ(formatCount(0, "object"), "0 objects");
  EXPECT_EQ(formatCount(1, "object"), "1 object");
  EXPECT_EQ(formatCount(2, "object"), "2 objects");
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
