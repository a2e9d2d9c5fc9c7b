// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/config/config_file.h"

#include <gtest/gtest.h>

#include <fstream>

#include "support.h"

namespace tsg::config {
namespace {

struct Input {
  std::string world_frame = "world";
  double tolerance_s = 0.02;
  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("world_frame", self.world_frame, {}, "", "");
    v.field("tolerance_s", self.tolerance_s, {0.0, 1.0}, "s", "");
  }
};

struct Tracker {
  double window_s = 5.0;
  std::filesystem::path models;
  Input input;
  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("window_s", self.window_s, {0.0, 60.0}, "s", "");
    v.field("models", self.models, {}, "", "");
    v.group("input", self.input);
  }
};

/// A stage that takes no images, but names the frame.
struct SceneGraph {
  std::string world_frame = "world";
  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("world_frame", self.world_frame, {}, "", "");
  }
};

class ConfigFileTest : public ::testing::Test {
 protected:
  std::filesystem::path path() const { return folder_.path() / "my.yaml"; }
  template <typename Config>
  Config loadFile(const std::string& yaml, const char* stage) const {
    std::ofstream(path()) << yaml;
    return load<Config>(splitConfig(readConfigFile(path()), stage, listNames<Config>()), "test");
  }
  std::string errorOf(const std::string& yaml) const {
    try {
      loadFile<Tracker>(yaml, "tracker");
    } catch (const ConfigError& e) {
      return e.what();
    }
    return "";
  }
  test::TemporaryFolder folder_;
};

TEST_F(ConfigFileTest, AStageTakesWhatIsSharedAndItsOwnSectionWins) {
  const auto tracker = loadFile<Tracker>(
      "input: {world_frame: map, tolerance_s: 0.05}\n"
      "tracker: {window_s: 3, input: {tolerance_s: 0.1}}\n"
      "mesh_fusion: {input: {tolerance_s: 0.3}}\n",
      "tracker");
  EXPECT_EQ(tracker.window_s, 3.0);
  EXPECT_EQ(tracker.input.world_frame, "map");
  EXPECT_EQ(tracker.input.tolerance_s, 0.1);
}

TEST_F(ConfigFileTest, TheOrderOfSectionsDoesNotMatter) {
  const auto tracker = loadFile<Tracker>(
      "tracker: {input: {tolerance_s: 0.1}}\ninput: {tolerance_s: 0.05}\n", "tracker");
  EXPECT_EQ(tracker.input.tolerance_s, 0.1);
}

TEST_F(ConfigFileTest, AStageWithoutImagesTakesTheFrameOfTheInput) {
  EXPECT_EQ(loadFile<SceneGraph>("input: {world_frame: map, tolerance_s: 0.1}", "scene_graph")
                .world_frame,
            "map");
  EXPECT_EQ(loadFile<SceneGraph>("{input: {world_frame: map}, scene_graph: {world_frame: odom}}",
                                 "scene_graph")
                .world_frame,
            "odom");
}

TEST_F(ConfigFileTest, SharedPathsBeginAtTheFile) {
  EXPECT_EQ(loadFile<Tracker>("models: sets/a.yaml", "tracker").models,
            folder_.path() / "sets/a.yaml");
}

TEST_F(ConfigFileTest, AMisspeltSectionIsNamedWithTheNearestAndTheFile) {
  const std::string error = errorOf("trackr: {window_s: 3}");
  EXPECT_NE(error.find("unknown section 'trackr', did you mean 'tracker'?"), std::string::npos)
      << error;
  EXPECT_NE(error.find(path().string()), std::string::npos) << error;
}

TEST_F(ConfigFileTest, AParameterOutsideOfAnySectionIsAnError) {
  EXPECT_NE(errorOf("window_s: 3").find("unknown section 'window_s'"), std::string::npos);
}

TEST_F(ConfigFileTest, ASectionThatIsThereTwiceIsAnError) {
  EXPECT_NE(
      errorOf("tracker: {window_s: 3}\ntracker: {window_s: 4}").find("'tracker' is there twice"),
      std::string::npos);
}

TEST_F(ConfigFileTest, WhatIsNoMapIsAnErrorThatNamesTheFile) {
  EXPECT_NE(errorOf("- tracker").find("expected a map with a section for each stage"),
            std::string::npos);
  EXPECT_NE(errorOf("tracker: 5").find("is not a map of parameters (file '" + path().string()),
            std::string::npos)
      << errorOf("tracker: 5");
  EXPECT_NE(errorOf("input: on").find("input is not a map"), std::string::npos)
      << errorOf("input: on");
}

TEST_F(ConfigFileTest, EmptyFilesAndSectionsHoldNothing) {
  EXPECT_EQ(errorOf(""), "");
  EXPECT_EQ(errorOf("tracker:\n"), "");
  EXPECT_EQ(errorOf("input:\n"), "");
  EXPECT_TRUE(splitConfig(readConfigFile(""), "tracker", {}).empty());
}

TEST_F(ConfigFileTest, ThePackagedDefaultsAreValidYaml) {
  const Source whole =
      readConfigFile(std::filesystem::path(TSG_SOURCE_DIR) / "config" / "default.yaml");
  EXPECT_TRUE(whole.parameters["input"].IsMap());
}

}  // namespace
}  // namespace tsg::config
