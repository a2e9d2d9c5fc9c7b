// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/end_report.h"

#include <gtest/gtest.h>

#include <fstream>

#include "support.h"
#include "task_scene_graph/ros/stage_report.h"
#include "task_scene_graph/ros/task_loader.h"

namespace tsg::ros_interface {
namespace {

const EndReport kMesh{"/mesh_fusion", "/home/u/map", {{"mesh.ply", "3 vertices"}}, "", ""};
const EndReport kGraph{"/scene_graph", "/home/u/map", {{"summary.json", ""}}, "", ""};

TEST(EndReport, FilesOfOneFolderAreOneLine) {
  EXPECT_EQ(describeEnd({kMesh, kGraph}), "wrote /home/u/map: mesh.ply (3 vertices), summary.json");
  EXPECT_FALSE(kMesh.isMissing());
}

TEST(EndReport, NothingWrittenIsSaidWithTheFirstReasonOfTheChain) {
  EndReport mesh = kMesh;
  mesh.files.clear();
  mesh.reason = "150 colour images arrived, none was usable (150 dropped: stamp is 0)";
  EndReport graph = kGraph;
  graph.files.clear();
  graph.reason = "no places";
  EXPECT_EQ(describeEnd({mesh, graph}), "no map was written: " + mesh.reason);
  EXPECT_TRUE(mesh.isMissing());
}

TEST(EndReport, WithoutAFolderNothingIsSaid) {
  EndReport mesh = kMesh;
  mesh.folder.clear();
  mesh.files.clear();
  mesh.reason = "no colour image arrived";
  EXPECT_EQ(describeEnd({mesh}), "");
  EXPECT_FALSE(mesh.isMissing());
}

TEST(EndReport, AFailedFileIsSaidBesideThoseThatWereWritten) {
  EndReport graph = kGraph;
  graph.files.clear();
  graph.problem = "map not saved: the disk is full";
  EXPECT_EQ(describeEnd({kMesh, graph}),
            "wrote /home/u/map: mesh.ply (3 vertices); map not saved: the disk is full");
  EXPECT_TRUE(graph.isMissing());
}

TEST(EndGatherer, GathersInTheOrderOfTheChainAndOnlyOnce) {
  EndGatherer gatherer;
  reportEnd(kGraph);  // the last stage ends first
  reportEnd(kMesh);
  const auto reports = gatherer.collect();
  ASSERT_EQ(reports.size(), 2U);
  EXPECT_EQ(reports[0].stage, "/mesh_fusion");
  EXPECT_TRUE(gatherer.collect().empty());
}

TEST(StageReport, SaysWhatBecameOfTheInput) {
  StageReport report("/tracker");
  EXPECT_EQ(report.describeInput("image"), "no image arrived");
  for (int i = 0; i < 3; ++i) report.countInput();
  EXPECT_EQ(report.describeInput("image"), "3 images arrived, none was usable");
  report.countDropped("no transform", "", 1);
  report.countDropped("stamp is 0", "", 2);
  EXPECT_EQ(report.describeInput("image"),
            "3 images arrived, none was usable (2 dropped: stamp is 0, 1 dropped: no transform)");
}

class TaskFiles : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& yaml) const {
    const auto path = folder_.path() / name;
    std::ofstream(path) << yaml;
    return path.string();
  }
  test::TemporaryFolder folder_;
};

TEST_F(TaskFiles, EveryFileWithoutATaskIsNamedInAWarning) {
  language::WordEncoder no_models("");
  const std::string one = write("one.yaml", "tasks: [{name: a, embedding: [1, 0]}]");
  for (const char* yaml : {"tasks: []", "", "[]", "# none", "tasks:", "{}"}) {
    const std::string none = write("none.yaml", yaml);
    const auto objects = loadChainTasks(none, one, no_models);
    ASSERT_EQ(objects.warnings.size(), 1U) << yaml;
    EXPECT_EQ(objects.warnings[0],
              "task file '" + none + "' holds no task: there will be no objects");
    const auto places = loadChainTasks(one, none, no_models);
    ASSERT_EQ(places.warnings.size(), 1U) << yaml;
    EXPECT_EQ(places.warnings[0],
              "task file '" + none + "' holds no task: regions will have no names");
    EXPECT_EQ(places.objects.size(), 1U);
  }
  const std::string none = write("none.yaml", "tasks: []");
  ASSERT_EQ(loadChainTasks(none, "", no_models).warnings.size(), 1U);
  EXPECT_NE(loadChainTasks(none, "", no_models).warnings[0].find("regions"), std::string::npos);
  EXPECT_TRUE(loadChainTasks(one, "", no_models).warnings.empty());
}

}  // namespace
}  // namespace tsg::ros_interface
