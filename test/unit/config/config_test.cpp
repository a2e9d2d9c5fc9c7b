// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/config/config.h"

#include <gtest/gtest.h>

namespace tsg::config {
namespace {

enum class Colour { kRed, kBlue };

struct Inner {
  int count = 3;
  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("count", self.count, {1, 9}, "", "how many");
  }
};

struct Outer {
  double length_m = 0.5;
  bool enabled = true;
  std::string name = "x";
  Colour colour = Colour::kRed;
  Inner inner;
  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("length_m", self.length_m, {0.0, 2.0}, "m", "how long");
    v.field("enabled", self.enabled, {}, "", "whether");
    v.field("name", self.name, {}, "", "who");
    v.choice("colour", self.colour, Choices<Colour>{{"red", Colour::kRed}, {"blue", Colour::kBlue}},
             "which");
    v.group("inner", self.inner);
  }
};

std::string errorOf(const std::string& yaml) {
  try {
    load<Outer>(YAML::Load(yaml), "test configuration");
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "";
}

TEST(Config, AbsentFieldsKeepTheirDefaults) {
  const auto outer = load<Outer>(YAML::Load("{length_m: 1.5, inner: {count: 4}}"), "test");
  EXPECT_DOUBLE_EQ(outer.length_m, 1.5);
  EXPECT_EQ(outer.inner.count, 4);
  EXPECT_EQ(outer.name, "x");
}

TEST(Config, WritingAndLoadingGivesTheSameStruct) {
  Outer outer;
  outer.length_m = 1.25;
  outer.colour = Colour::kBlue;
  outer.inner.count = 7;
  const auto again = load<Outer>(toYaml(outer), "test");
  EXPECT_DOUBLE_EQ(again.length_m, 1.25);
  EXPECT_EQ(again.colour, Colour::kBlue);
  EXPECT_EQ(again.inner.count, 7);
}

TEST(Config, UnknownKeyIsNamedWithTheNearestKnownOne) {
  const std::string error = errorOf("{lenght_m: 1.0}");
  EXPECT_NE(error.find("unknown parameter 'lenght_m', did you mean 'length_m'?"), std::string::npos)
      << error;
}

TEST(Config, AllViolationsAreReportedAtOnce) {
  const std::string error =
      errorOf("{length_m: 3, enabled: maybe, colour: green, inner: {count: 0, x: 1}}");
  for (const char* part :
       {"test configuration", "'length_m' is 3, expected a value in [0, 2] m",
        "'enabled' is 'maybe', expected bool", "'colour' is 'green', expected one of red, blue",
        "'inner/count' is 0", "unknown parameter 'inner/x'"}) {
    EXPECT_NE(error.find(part), std::string::npos) << part << " not in " << error;
  }
}

TEST(Config, NanIsOutOfEveryRange) {
  EXPECT_NE(errorOf("{length_m: .nan}").find("length_m"), std::string::npos);
}

TEST(Config, AListInPlaceOfAMapIsAnError) {
  EXPECT_NE(errorOf("[1, 2]").find("not a map"), std::string::npos);
}

TEST(Config, DescribeListsEveryFieldInOrder) {
  const auto rows = describe<Outer>();
  ASSERT_EQ(rows.size(), 5U);
  EXPECT_EQ(rows[0].name, "length_m");
  EXPECT_EQ(rows[0].unit, "m");
  EXPECT_EQ(rows[0].range, "[0, 2]");
  EXPECT_EQ(rows[3].default_value, "red");
  EXPECT_EQ(rows[4].name, "inner/count");
}

TEST(Config, MissingFileIsNamed) {
  try {
    loadYamlFile("/no/such/file.yaml");
    FAIL();
  } catch (const ConfigError& e) {
    EXPECT_NE(std::string(e.what()).find("/no/such/file.yaml"), std::string::npos);
  }
}

}  // namespace
}  // namespace tsg::config
