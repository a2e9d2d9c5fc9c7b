// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/config/config.h"

#include <gtest/gtest.h>

#include <fstream>

#include "support.h"

namespace tsg::config {
namespace {

enum class Colour { kRed, kBlue };

struct Calibrated {
  NumbersOrPath camera;
  Colour colour = Colour::kBlue;
  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("camera", self.camera, {}, "", "numbers or a file");
    v.choice("colour", self.colour,
             Choices<Colour>{
                 {"red", Colour::kRed}, {"deep_blue", Colour::kBlue}, {"blue", Colour::kBlue}},
             "which");
  }
};

struct Inner {
  int count = 3;
  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("count", self.count, {1, 9}, "", "how many");
  }
};

struct Outer {
  std::filesystem::path file;
  std::vector<double> gains;
  std::vector<std::string> words;
  double length_m = 0.5;
  bool enabled = true;
  std::string name = "x";
  Colour colour = Colour::kRed;
  Inner inner;
  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("file", self.file, {}, "", "where");
    v.field("gains", self.gains, {0.0, 10.0}, "", "how strong");
    v.field("words", self.words, {}, "", "what");
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

TEST(Config, NumbersStayAndPathsBeginAtTheFolderOfTheirSource) {
  const auto read = [](const std::string& text) {
    YAML::Node map;
    map["camera"] = text;
    return load<Calibrated>({{"file", map, "/robot/config"}}, "test").camera.text;
  };
  EXPECT_EQ(read("1, 2,3.5 4e2"), "1, 2,3.5 4e2");
  EXPECT_EQ(read("[1, 2; 3]"), "[1, 2; 3]");
  EXPECT_EQ(read("camera.yaml"), "/robot/config/camera.yaml");
  EXPECT_EQ(read("../1.txt"), "/robot/1.txt");
  EXPECT_EQ(read("/camera.yaml"), "/camera.yaml");
  EXPECT_EQ(read(""), "");
}

TEST(Config, NumberInThePlaceOfNumbersOrAPathIsRefused) {
  YAML::Node number(std::string("5"));
  number.SetTag(kIntTag);
  YAML::Node map;
  map["camera"] = number;
  EXPECT_THROW(load<Calibrated>(map, "test"), ConfigError);
}

TEST(Config, FirstNameOfAChoiceIsPrintedAndAllAreRead) {
  const auto read = [](const std::string& text) {
    return load<Calibrated>(YAML::Load("{colour: " + text + "}"), "test").colour;
  };
  EXPECT_EQ(read("red"), Colour::kRed);
  for (const char* text : {"blue", "deep_blue", "deep-blue"}) {
    EXPECT_EQ(read(text), Colour::kBlue) << text;
  }
  EXPECT_EQ(toYaml(Calibrated{})["colour"].as<std::string>(), "deep_blue");
  EXPECT_EQ(describe<Calibrated>()[1].default_value, "deep_blue");
  EXPECT_THROW(read("deep blue"), ConfigError);
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
  ASSERT_EQ(rows.size(), 8U);
  EXPECT_EQ(rows[0].default_value, "\"\"");
  EXPECT_EQ(rows[3].name, "length_m");
  EXPECT_EQ(rows[3].unit, "m");
  EXPECT_EQ(rows[3].range, "[0, 2]");
  EXPECT_EQ(rows[6].default_value, "red");
  EXPECT_EQ(rows[7].name, "inner/count");
}

Source makeSource(const std::string& name, const std::string& yaml) {
  return {name, YAML::Load(yaml), "/folder/of/" + name};
}

TEST(Sources, LaterOnesWinAndEachValueKnowsItsOrigin) {
  Origins origins;
  const auto outer =
      load<Outer>({makeSource("first", "{length_m: 1.5, name: a, inner: {count: 4}}"),
                   makeSource("second", "{name: b, colour: blue}")},
                  "test", {}, &origins);
  EXPECT_EQ(outer.length_m, 1.5);
  EXPECT_EQ(outer.name, "b");
  EXPECT_EQ(outer.inner.count, 4);
  const Origins expected{
      {"length_m", "first"}, {"inner/count", "first"}, {"name", "second"}, {"colour", "second"}};
  EXPECT_EQ(origins, expected);
}

TEST(Sources, EveryViolationNamesItsSource) {
  try {
    load<Outer>({makeSource("first", "{lenght_m: 1}"),
                 makeSource("second", "{length_m: x, inner: {count: 99}}")},
                "test");
    FAIL();
  } catch (const ConfigError& e) {
    const std::string error = e.what();
    for (const char* part : {"did you mean 'length_m'? (first)", "expected double (second)",
                             "'inner/count' is 99, expected a value in [1, 9] (second)"}) {
      EXPECT_NE(error.find(part), std::string::npos) << part << " not in " << error;
    }
  }
}

TEST(Sources, PathsBeginAtTheFolderOfTheirSource) {
  const auto outer = load<Outer>({makeSource("second", "{file: ../maps/a.yaml}")}, "test");
  EXPECT_EQ(outer.file, "/folder/of/maps/a.yaml");
  EXPECT_NE(errorOf("{file: 'http://x/y'}").find("parameter 'file': path 'http://x/y': expected"),
            std::string::npos);
}

TEST(Config, AKeyThatIsThereTwiceIsAnError) {
  EXPECT_NE(errorOf("{length_m: 1, length_m: 2}").find("'length_m' is there twice"),
            std::string::npos);
  EXPECT_NE(errorOf("{inner: {count: 3, count: 3}}").find("'inner/count' is there twice"),
            std::string::npos);
}

TEST(Config, AnEmptyValueIsAnErrorAndAnEmptyGroupIsNone) {
  for (const char* yaml : {"{length_m: }", "{length_m: ~}", "{name: null}", "{enabled: }",
                           "{colour: }", "{file: ~}", "{words: }"}) {
    EXPECT_NE(errorOf(yaml).find("is empty, expected"), std::string::npos) << yaml;
  }
  EXPECT_EQ(errorOf("{inner: }"), "");
}

TEST(Config, NumbersAreReadAsPeopleWriteThem) {
  for (const auto& [text, value] :
       {std::pair{"1e-3", 1e-3}, {".5", 0.5}, {"'0.25'", 0.25}, {"1", 1.0}}) {
    const auto outer = load<Outer>(YAML::Load("{length_m: " + std::string(text) + "}"), "test");
    EXPECT_EQ(outer.length_m, value) << text;
  }
  EXPECT_EQ(load<Outer>(YAML::Load("{inner: {count: 2.0}}"), "test").inner.count, 2);
  EXPECT_EQ(load<Outer>(YAML::Load("{gains: [1, 2.5, 1e-1]}"), "test").gains,
            (std::vector<double>{1.0, 2.5, 0.1}));
  EXPECT_NE(errorOf("{inner: {count: 2.5}}").find("'inner/count' is '2.5', expected int"),
            std::string::npos);
  EXPECT_NE(errorOf("{inner: {count: 010}}").find("octal"), std::string::npos);
  EXPECT_NE(errorOf("{inner: {count: true}}").find("expected int"), std::string::npos);
  EXPECT_NE(errorOf("{enabled: 1}").find("expected bool"), std::string::npos);
  EXPECT_NE(errorOf("{length_m: [1]}").find("expected double"), std::string::npos);
  EXPECT_NE(errorOf("{gains: 1}").find("expected list of numbers"), std::string::npos);
}

TEST(Config, StringsAreTheTextOfTheFile) {
  for (const char* text : {"on", "123", "1e3", "010", "1.50", "2024-01-01", "0x10", "yes"}) {
    EXPECT_EQ(load<Outer>(YAML::Load("{name: " + std::string(text) + "}"), "test").name, text);
  }
  EXPECT_EQ(load<Outer>(YAML::Load("{words: [on, 1, a b]}"), "test").words,
            (std::vector<std::string>{"on", "1", "a b"}));
}

TEST(Config, WhatAServerHasTypedIsNoString) {
  YAML::Node map;
  map["name"] = "8";
  map["name"].SetTag(kIntTag);
  try {
    load<Outer>(map, "test");
    FAIL();
  } catch (const ConfigError& e) {
    EXPECT_NE(
        std::string(e.what()).find("'name' is the number 8, expected string: put it in quotes"),
        std::string::npos)
        << e.what();
  }
}

TEST(Config, ControlCharactersInValuesDoNotEndTheMessage) {
  const std::string error = errorOf("length_m: \"1\\0 2\"");
  EXPECT_NE(error.find("is '1\\x00 2', expected"), std::string::npos) << error;
}

TEST(Config, TopLevelNamesAreListed) {
  EXPECT_EQ(listNames<Outer>(), (std::vector<std::string>{"file", "gains", "words", "length_m",
                                                          "enabled", "name", "colour", "inner"}));
}

std::string errorOfFile(const std::filesystem::path& path) {
  try {
    loadYamlFile(path.string());
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "";
}

TEST(YamlFile, ErrorsNameTheFileAndTheLine) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "x.yaml";
  std::ofstream(path) << "a: 1\nb: [1, 2\nc: 3\n";
  EXPECT_NE(errorOfFile(path).find(path.string()), std::string::npos) << errorOfFile(path);
  EXPECT_NE(errorOfFile(path).find("line 3"), std::string::npos) << errorOfFile(path);
  std::ofstream(path) << "a: 1\n---\na: 2\n";
  EXPECT_NE(errorOfFile(path).find("2 documents"), std::string::npos);
  EXPECT_NE(errorOfFile(folder.path()).find("is a folder"), std::string::npos);
}

TEST(YamlFile, ACommaWhereADocumentBeginsIsRefusedByName) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "x.yaml";
  for (const char* text : {", a\n- b\n", ",", "] a\n"}) {
    std::ofstream(path) << text;
    EXPECT_NE(errorOfFile(path).find(path.string()), std::string::npos) << text;
  }
}

TEST(YamlFile, AliasesWithoutEndAreRefusedByName) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "x.yaml";
  for (const char* text : {"a: &a [*a]\n", "a: &a {b: *a}\n", "a: &a {? *a : 1}\n"}) {
    std::ofstream(path) << text;
    const std::string error = errorOfFile(path);
    EXPECT_NE(error.find(path.string()), std::string::npos) << text << error;
    EXPECT_NE(error.find("alias"), std::string::npos) << text << error;
  }
}

TEST(YamlFile, AliasesThatStandForBillionsAreRefusedByName) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "x.yaml";
  std::ofstream file(path);
  file << "a0: &a0 1\n";
  for (int i = 1; i <= 30; ++i) {
    const std::string before = "*a" + std::to_string(i - 1);
    file << "a" << i << ": &a" << i << " [" << before << ", " << before << ", " << before << "]\n";
  }
  file.close();
  EXPECT_NE(errorOfFile(path).find(path.string()), std::string::npos);
  EXPECT_NE(errorOfFile(path).find("aliases (*) stand for many times"), std::string::npos);
}

TEST(YamlFile, AliasesOfOneValueAreFine) {
  const test::TemporaryFolder folder;
  std::ofstream(folder.path() / "x.yaml") << "a: &a [1, 2]\nb: *a\n";
  EXPECT_EQ(loadYamlFile((folder.path() / "x.yaml").string())["b"][1].as<int>(), 2);
}

TEST(YamlFile, WhatYamlCppNeverComesBackFromIsRefusedByName) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "damaged.yaml";
  for (const char* text :
       {"[5:", "{5:", "- [5:", "a: [b:", "[? 5:", "[5:]", "a: [b, c:]\n", "{5:]"}) {
    std::ofstream(path) << text;
    EXPECT_NE(errorOfFile(path).find(path.string()), std::string::npos) << text;
  }
  std::ofstream(path) << "a: b\nc: [d:]\n";
  EXPECT_NE(errorOfFile(path).find("line 2: ':]' in brackets"), std::string::npos);
  std::ofstream(path) << "- smile :]\n- {a: b}\n- [5: ]\n";
  EXPECT_EQ(errorOfFile(path), "");
}

TEST(YamlFile, AnEmptyFileHoldsNothing) {
  const test::TemporaryFolder folder;
  std::ofstream(folder.path() / "x.yaml") << "# nothing\n";
  EXPECT_TRUE(loadYamlFile((folder.path() / "x.yaml").string()).IsNull());
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
