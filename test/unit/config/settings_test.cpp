// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/config/settings.h"

#include <gtest/gtest.h>

#include <sstream>

#include "task_scene_graph/config/config_file.h"

namespace tsg::config {
namespace {

enum class Colour { kRed, kBlue };

struct Input {
  std::string world_frame = "world";
  double tolerance_s = 0.02;
  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("world_frame", self.world_frame, {}, "", "");
    v.field("tolerance_s", self.tolerance_s, {0.0, 1.0}, "s", "");
  }
};

struct Stage {
  double window_s = 5.0;
  Input input;
  int count = 3;
  bool enabled = true;
  Colour colour = Colour::kRed;
  std::string name;
  std::filesystem::path file;
  std::vector<double> gains;
  std::vector<std::string> words;
  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("window_s", self.window_s, {0.0, 60.0}, "s", "");
    v.group("input", self.input);
    v.field("count", self.count, {0, 9}, "", "");
    v.field("enabled", self.enabled, {}, "", "");
    v.choice("colour", self.colour, Choices<Colour>{{"red", Colour::kRed}, {"blue", Colour::kBlue}},
             "");
    v.field("name", self.name, {}, "", "");
    v.field("file", self.file, {}, "", "");
    v.field("gains", self.gains, {}, "", "");
    v.field("words", self.words, {}, "", "");
  }
};

Stage makeStage() {
  Stage stage;
  stage.window_s = 1.0 / 3.0;
  stage.input.world_frame = "map";
  stage.count = 7;
  stage.enabled = false;
  stage.colour = Colour::kBlue;
  stage.name = "on: \"1\"";
  stage.file = "/a b/c.yaml";
  stage.gains = {1e-5, 2.0};
  stage.words = {"no", "~", ""};
  return stage;
}

std::string write(const std::vector<StageSettings>& stages) {
  std::ostringstream stream;
  writeSettings(stream, {{"program", quoteYaml("test"), ""}}, stages);
  return stream.str();
}

Stage readBack(const std::string& text, const char* stage) {
  return load<Stage>(splitConfig({"file", YAML::Load(text), {}}, stage, listNames<Stage>()),
                     "test");
}

std::string dump(const Stage& stage) { return YAML::Dump(toYaml(stage)); }

TEST(Settings, EachHasItsValueAndItsOrigin) {
  const auto settings = listSettings(makeStage(), {{"window_s", "file 'x'"}});
  ASSERT_EQ(settings.size(), 10U);
  EXPECT_EQ(settings[0].name, "window_s");
  EXPECT_EQ(settings[0].value, "0.3333333333333333");
  EXPECT_EQ(settings[0].origin, "file 'x'");
  EXPECT_EQ(settings[1].name, "input/world_frame");
  EXPECT_EQ(settings[1].value, "\"map\"");
  EXPECT_EQ(settings[1].origin, "default");
}

TEST(Settings, AFileOfThemGivesTheSameSettings) {
  Stage other = makeStage();
  other.input.tolerance_s = 0.5;
  const std::string text =
      write({{"tracker", listSettings(makeStage(), {})}, {"mesh_fusion", listSettings(other, {})}});
  EXPECT_EQ(dump(readBack(text, "tracker")), dump(makeStage())) << text;
  EXPECT_EQ(dump(readBack(text, "mesh_fusion")), dump(other)) << text;
}

TEST(Settings, WhatTheStagesAgreeOnOfTheInputIsWrittenOnce) {
  Stage other = makeStage();
  other.input.tolerance_s = 0.5;
  const YAML::Node file = YAML::Load(write(
      {{"tracker", listSettings(makeStage(), {})}, {"mesh_fusion", listSettings(other, {})}}));
  EXPECT_EQ(file["input"]["world_frame"].as<std::string>(), "map");
  EXPECT_FALSE(file["input"]["tolerance_s"].IsDefined());
  EXPECT_FALSE(file["tracker"]["input"]["world_frame"].IsDefined());
  EXPECT_EQ(file["mesh_fusion"]["input"]["tolerance_s"].as<double>(), 0.5);
}

TEST(Settings, CommentsSayWhereWhatIsNoDefaultCameFrom) {
  const std::string text =
      write({{"tracker", listSettings(makeStage(), {{"count", "parameter server"}})}});
  EXPECT_NE(text.find("count: 7  # parameter server\n"), std::string::npos) << text;
  EXPECT_NE(text.find("enabled: false\n"), std::string::npos) << text;
}

TEST(Settings, TheRecordOfTheRunIsNotReadBack) {
  const YAML::Node file = YAML::Load(write({{"tracker", listSettings(makeStage(), {})}}));
  EXPECT_EQ(file["made_with"]["program"].as<std::string>(), "test");
}

}  // namespace
}  // namespace tsg::config
