// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/config/scalar.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <locale>
#include <random>

namespace tsg::config {
namespace {

TEST(ParseNumber, TakesWhatPeopleWrite) {
  const std::pair<const char*, double> cases[] = {
      {"3", 3.0},       {"+3", 3.0},    {"-2.5", -2.5},    {".5", 0.5},     {"-.5", -0.5},
      {"5.", 5.0},      {"1e-3", 1e-3}, {"1E-3", 1e-3},    {"1e3", 1000.0}, {"1.5e+2", 150.0},
      {"1.e2", 100.0},  {"0", 0.0},     {"0.0", 0.0},      {"-0", 0.0},     {"0x10", 16.0},
      {"-0x1F", -31.0}, {"0b101", 5.0}, {"1_000", 1000.0}, {"1_0.5", 10.5}, {"1e-400", 0.0},
      {"00.5", 0.5}};
  for (const auto& [text, value] : cases) {
    ASSERT_TRUE(parseNumber(text).has_value()) << text;
    EXPECT_EQ(*parseNumber(text), value) << text;
  }
  EXPECT_TRUE(std::isinf(*parseNumber(".inf")));
  EXPECT_LT(*parseNumber("-.INF"), 0.0);
  EXPECT_TRUE(std::isnan(*parseNumber(".NaN")));
}

TEST(ParseNumber, RefusesWhatIsNoneOrReadDifferentlyElsewhere) {
  for (const char* text : {"",    " ",    "abc",   "1.2.3", "1,5",  "1e",   "e3",    "0x",   "0xg",
                           "0b2", "--1",  "1 2",   "010",   "-007", "0_10", "0o10",  "1:30", "inf",
                           "nan", "true", "1e999", "_1",    "1m",   "5 %",  "1e1.5", "."}) {
    EXPECT_FALSE(parseNumber(text).has_value()) << text;
  }
}

class CommaForPoint : public std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
};

TEST(ParseNumber, DoesNotDependOnTheLocale) {
  const std::locale old =
      std::locale::global(std::locale(std::locale::classic(), new CommaForPoint));
  const auto number = parseNumber("0.5");
  const std::string text = formatExactly(0.5);
  std::locale::global(old);
  EXPECT_EQ(number, 0.5);
  EXPECT_EQ(text, "0.5");
}

TEST(ParseInteger, TakesWholeNumbersHoweverWritten) {
  EXPECT_EQ(parseInteger("2.0"), 2);
  EXPECT_EQ(parseInteger("1e3"), 1000);
  EXPECT_EQ(parseInteger("0x10"), 16);
  EXPECT_EQ(parseInteger("-2147483648"), std::numeric_limits<int>::min());
  for (const char* text : {"2.5", "2147483648", "1e20", ".inf", ".nan", "true", "010"}) {
    EXPECT_FALSE(parseInteger(text).has_value()) << text;
  }
}

TEST(ParseBool, TakesTheWordsOfYaml) {
  for (const char* text : {"true", "True", "TRUE", "yes", "on", "On", "y"}) {
    EXPECT_EQ(parseBool(text), true) << text;
  }
  for (const char* text : {"false", "no", "NO", "off", "n"})
    EXPECT_EQ(parseBool(text), false) << text;
  for (const char* text : {"1", "0", "tRuE", "", "maybe", "1.0"}) {
    EXPECT_FALSE(parseBool(text).has_value()) << text;
  }
}

TEST(FormatExactly, IsReadBackToTheLastBit) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> mantissa(-10.0, 10.0);
  std::uniform_int_distribution<int> exponent(-300, 300);
  for (int i = 0; i < 2000; ++i) {
    const double value = mantissa(random) * std::pow(10.0, exponent(random));
    EXPECT_EQ(parseNumber(formatExactly(value)), value) << formatExactly(value);
  }
}

TEST(FormatExactly, IsShortAndNoStringToYaml11) {
  EXPECT_EQ(formatExactly(0.05), "0.05");
  EXPECT_EQ(formatExactly(1e-5), "1.0e-05");
  EXPECT_EQ(formatExactly(2.0), "2");
  EXPECT_EQ(formatExactly(1.0 / 3.0), "0.3333333333333333");
  EXPECT_EQ(formatExactly(-std::numeric_limits<double>::infinity()), "-.inf");
}

TEST(ExplainNumber, SaysWhatIsWrongWhereItIsKnown) {
  EXPECT_NE(explainNumber("010").find("octal"), std::string::npos);
  EXPECT_NE(explainNumber("0,05").find("0.05"), std::string::npos);
  EXPECT_EQ(explainNumber("abc"), "");
}

TEST(QuoteYaml, IsReadBackAsTheSameString) {
  for (const std::string text : {"", "on", "~", "null", "1.50", "a: b # c", "say \"hi\"",
                                 "back\\slash", "tab\tnew\nline", "\xc3\xa4", "- x", "{a}"}) {
    const YAML::Node node = YAML::Load(quoteYaml(text));
    ASSERT_TRUE(node.IsScalar()) << text;
    EXPECT_EQ(node.Scalar(), text);
  }
}

}  // namespace
}  // namespace tsg::config
