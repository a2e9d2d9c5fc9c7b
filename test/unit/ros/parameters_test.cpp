// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/parameters.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include "task_scene_graph/ros/settings_conversions.h"

namespace tsg::ros_interface {
namespace {

using XmlRpc::XmlRpcValue;

struct AnyConfig {
  double number = -1.0;
  int integer = -1;
  bool flag = false;
  std::string text = "unset";
  std::vector<double> numbers;
  std::vector<std::string> texts;
  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("number", self.number, {}, "", "");
    v.field("integer", self.integer, {}, "", "");
    v.field("flag", self.flag, {}, "", "");
    v.field("text", self.text, {}, "", "");
    v.field("numbers", self.numbers, {}, "", "");
    v.field("texts", self.texts, {}, "", "");
  }
};

/// What the configuration is after the parameter was given; nothing if it was refused.
std::optional<std::string> give(const std::string& name, const YAML::Node& value) {
  YAML::Node map(YAML::NodeType::Map);
  map[name] = value;
  try {
    return YAML::Dump(config::toYaml(config::load<AnyConfig>(map, "test")));
  } catch (const config::ConfigError&) {
    return std::nullopt;
  }
}

/// A text in a file, and what PyYAML makes of it on its way to the parameter server.
struct Case {
  const char* text;
  XmlRpcValue value;
};

std::vector<Case> listCases() {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto string = [](const char* text) { return XmlRpcValue(std::string(text)); };
  return {{"1e-3", string("1e-3")},
          {"1e3", string("1e3")},
          {".5", 0.5},
          {"-.5", string("-.5")},
          {"0.5", 0.5},
          {"1.0e-3", 1.0e-3},
          {"2", 2},
          {"2.0", 2.0},
          {"1_000", 1000},
          {"010", 8},
          {"08", string("08")},
          {"0x10", 16},
          {"0b11", 3},
          {"0o17", string("0o17")},
          {"1:30", 90},
          {".inf", infinity},
          {"-.inf", -infinity},
          {"yes", true},
          {"on", true},
          {"off", false},
          {"True", true},
          {"y", string("y")},
          {"'0.5'", string("0.5")},
          {"'on'", string("on")},
          {"abc", string("abc")},
          {"''", string("")},
          {"1,5", string("1,5")},
          {"12345678.9", 12345678.9}};
}

TEST(SameTextSameValue, OrAnErrorFromFileAndParameterServer) {
  int num_same = 0;
  for (const auto& [text, value] : listCases()) {
    for (const char* name : {"number", "integer", "flag", "text"}) {
      const auto from_file = give(name, YAML::Load(text));
      const auto from_server = give(name, toYaml(value));
      if (!from_file || !from_server) continue;
      EXPECT_EQ(*from_file, *from_server) << name << ": " << text;
      ++num_same;
    }
  }
  EXPECT_GT(num_same, 30);
}

TEST(SameTextSameValue, NumbersAreAcceptedFromBothHoweverWritten) {
  for (const auto& [text, value] : listCases()) {
    const std::string literal = text;
    const bool is_number = literal.find_first_not_of("0123456789.e-_x") == std::string::npos;
    if (!is_number || literal == "010" || literal == "08") continue;
    EXPECT_TRUE(give("number", YAML::Load(text))) << text;
    EXPECT_TRUE(give("number", toYaml(value))) << text;
  }
}

TEST(SameTextSameValue, AListIsReadItemByItem) {
  XmlRpcValue numbers;
  numbers[0] = 1;
  numbers[1] = 2.5;
  numbers[2] = std::string("1e-3");
  EXPECT_EQ(give("numbers", toYaml(numbers)), give("numbers", YAML::Load("[1, 2.5, 1e-3]")));
  XmlRpcValue words;
  words[0] = true;
  EXPECT_FALSE(give("texts", toYaml(words)));
}

TEST(ToYaml, DoublesKeepEveryBit) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> exponent(-30.0, 30.0);
  for (int i = 0; i < 1000; ++i) {
    const double value = std::pow(10.0, exponent(random));
    XmlRpcValue map;
    map["number"] = value;
    EXPECT_EQ(config::load<AnyConfig>(toYaml(map), "test").number, value);
  }
}

TEST(ToYaml, BinaryDataIsRefusedByName) {
  XmlRpcValue map;
  char bytes[] = "abc";
  map["group"]["picture"] = XmlRpcValue(bytes, 3);
  try {
    toYaml(map);
    FAIL();
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("'group/picture'"), std::string::npos) << e.what();
  }
}

struct SuggestedConfig {
  static constexpr const char* kStage = "scene_graph";
  std::string models;
  double alpha = 0.23;
  double delta = 0.5;
  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("models", self.models, {}, "", "");
    v.field("alpha", self.alpha, {0.0, 1.0}, "", "");
    v.field("delta", self.delta, {0.0, 1.0}, "", "");
  }
};

std::vector<config::Source> suggest(const SuggestedConfig& config) {
  if (config.models.empty()) return {};
  return {{"model set", YAML::Load("{alpha: 0.4}"), {}}};
}

TEST(LoadStage, SuggestionsLieBetweenPackagedDefaultsAndTheUsersFile) {
  const config::Source packaged{"packaged", YAML::Load("{alpha: 0.1, delta: 0.1}"), {}};
  const config::Source names_models{"file", YAML::Load("{models: m}"), {}};
  const config::Source own_alpha{"file", YAML::Load("{models: m, alpha: 0.3}"), {}};
  const auto suggested = loadStage<SuggestedConfig>({{packaged}, {names_models}}, "test", suggest);
  EXPECT_EQ(suggested.config.alpha, 0.4);
  EXPECT_EQ(suggested.origins.at("alpha"), "model set");
  EXPECT_EQ(suggested.config.delta, 0.1);
  const auto own = loadStage<SuggestedConfig>({{packaged}, {own_alpha}}, "test", suggest);
  EXPECT_EQ(own.config.alpha, 0.3);
  EXPECT_EQ(own.origins.at("alpha"), "file");
  EXPECT_EQ(loadStage<SuggestedConfig>({{packaged}, {}}, "test", suggest).config.alpha, 0.1);
}

TEST(SettingsConversion, RoundTripGivesTheSameSettings) {
  const config::StageSettings settings{
      "tracker", {{"window_s", "3", "default"}, {"a/b", "\"x\"", "file 'y'"}}};
  const auto again = fromMessage(toMessage(settings));
  EXPECT_EQ(again.stage, "tracker");
  ASSERT_EQ(again.settings.size(), 2U);
  EXPECT_EQ(again.settings[1].name, "a/b");
  EXPECT_EQ(again.settings[1].value, "\"x\"");
  EXPECT_EQ(again.settings[1].origin, "file 'y'");
}

}  // namespace
}  // namespace tsg::ros_interface
