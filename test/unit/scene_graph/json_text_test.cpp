// SPDX-License-Identifier: BSD-3-Clause
#include "scene_graph/json_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <random>

#include "scene_graph/json_numbers.h"

namespace tsg::scene_graph {
namespace {

using nlohmann::json;

/// Why a text is refused; "" if it is not.
std::string errorOf(const std::string& text) {
  try {
    JsonText{text};
  } catch (const std::exception& e) {
    return e.what();
  }
  return "";
}

std::string copyAll(const JsonText& text) { return text.copy(text.root()); }

std::uint32_t bitsOf(float value) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof(bits));
  return bits;
}

/// JSON-like texts: most are JSON, or nearly.
class TextMaker {
 public:
  explicit TextMaker(unsigned seed) : random_(seed) {}

  std::string make() {
    std::string text = makeValue(4);
    for (std::size_t i = pick(3); i > 0; --i) spoil(text);
    return text;
  }

 private:
  std::size_t pick(std::size_t count) {
    return std::uniform_int_distribution<std::size_t>(0, count - 1)(random_);
  }

  std::string makeScalar() {
    static const std::string kScalars[] = {"0",
                                           "-0",
                                           "12",
                                           "-3.5",
                                           "1e5",
                                           "2.5E-7",
                                           "true",
                                           "false",
                                           "null",
                                           "\"\"",
                                           "\"a b\"",
                                           "\"\\n\"",
                                           "\"\\u00e9\"",
                                           "\"\\ud83e\\udd16\"",
                                           "\"\xc3\xa9\"",
                                           "\"\xf0\x9f\xa4\x96\"",
                                           "1e-400",
                                           "0.1e+3",
                                           "123456789012345678901234"};
    return kScalars[pick(std::size(kScalars))];
  }

  std::string makeValue(int depth) {
    const std::string space = pick(4) == 0 ? " " : "";
    if (depth == 0 || pick(3) == 0) return space + makeScalar();
    const bool is_object = pick(2) == 0;
    std::string text(is_object ? "{" : "[");
    const std::size_t count = pick(4);
    for (std::size_t i = 0; i < count; ++i) {
      if (i > 0) text += ',' + space;
      if (is_object) text += '"' + std::to_string(i) + "\":";
      text += makeValue(depth - 1);
    }
    return space + text + (is_object ? "}" : "]");
  }

  void spoil(std::string& text) {
    static const std::string kPieces[] = {",",    "\"",   "[", "]",       "{", "}",  ":",
                                          "\\",   "0",    "-", ".",       "e", "\n", " ",
                                          "\xff", "\xc3", "x", "\\ud800", "\t"};
    const std::size_t at = pick(text.size() + 1);
    if (pick(2) == 0) {
      text.insert(at, kPieces[pick(std::size(kPieces))]);
    } else {
      text.erase(std::min(at, text.size() - 1), 1 + pick(2));
    }
    if (text.empty()) text = "0";
  }

  std::mt19937 random_;
};

TEST(JsonText, TakesWhatAnotherParserTakesAndKeepsItsValue) {
  TextMaker maker(1);
  int num_taken = 0;
  int num_refused = 0;
  for (int i = 0; i < 20'000; ++i) {
    const std::string text = maker.make();
    const json expected = json::parse(text, nullptr, false);
    const std::string error = errorOf(text);
    if (error.empty() && JsonText(text).numOddNumbers() > 0) continue;  // 1e2345: theirs no number
    ASSERT_EQ(error.empty(), !expected.is_discarded()) << text << '\n' << error;
    ++(error.empty() ? num_taken : num_refused);
    if (!error.empty()) continue;
    ASSERT_EQ(json::parse(copyAll(JsonText(text))), expected) << text;
  }
  EXPECT_GT(num_taken, 5000);
  EXPECT_GT(num_refused, 2000);
}

TEST(JsonText, ObjectsAndArraysAreFoundAtAnyDepth) {
  std::string text = "7";
  for (int i = 0; i < 20; ++i) text = R"({"x": "]}", "a\u0062": [1, )" + text + R"( ], "z":0})";
  const JsonText file(text);
  JsonSpan value = file.root();
  for (int i = 0; i < 20; ++i) {
    const JsonObject object = file.readObject(value);
    ASSERT_EQ(object.fields().size(), 3U);
    EXPECT_EQ(file.copy(*object.find("x")), "\"]}\"");
    const auto elements = file.readArray(*object.find("ab"));
    ASSERT_EQ(elements.size(), 2U);
    value = elements[1];
  }
  EXPECT_EQ(file.readUnsigned(value), 7U);
  EXPECT_TRUE(file.readArray(value).empty());
  EXPECT_TRUE(file.readObject(value).fields().empty());
}

TEST(JsonText, OfFieldsOfOneNameTheLastCounts) {
  const JsonText file(R"({"a": 1, "b": 2, "a": 3})");
  const JsonObject object = file.readObject(file.root());
  ASSERT_EQ(object.fields().size(), 2U);
  EXPECT_EQ(file.copy(*object.find("a")), "3");
}

TEST(JsonText, FieldsAreFoundHoweverManyThereAre) {
  std::string text = "{";
  for (int i = 0; i < 1000; ++i) {
    text += (i == 0 ? "" : ",") + std::string("\"k") + std::to_string(i % 700) +
            "\":" + std::to_string(i);
  }
  const JsonText file(text + "}");
  const JsonObject object = file.readObject(file.root());
  ASSERT_EQ(object.fields().size(), 700U);
  for (std::uint64_t i = 0; i < 700; ++i) {
    const JsonSpan* value = object.find("k" + std::to_string(i));
    ASSERT_NE(value, nullptr);
    EXPECT_EQ(file.readUnsigned(*value), i < 300 ? i + 700 : i);
    EXPECT_EQ(object.fields()[i].key, "k" + std::to_string(i));
  }
  EXPECT_EQ(object.find("k700"), nullptr);
}

TEST(JsonText, WholeNumbersAreReadOnlyWhereTheyAreWhole) {
  const JsonText file(R"([18446744073709551615, 18446744073709551616, -1, 1.0, 1e2, "1", null])");
  const auto values = file.readArray(file.root());
  EXPECT_EQ(file.readUnsigned(values[0]), 18446744073709551615U);
  for (std::size_t i = 1; i < values.size(); ++i) EXPECT_FALSE(file.readUnsigned(values[i])) << i;
  EXPECT_EQ(file.readInteger(values[2]), -1);
  EXPECT_FALSE(file.readInteger(values[0]));
  EXPECT_FALSE(file.readInteger(values[3]));
}

TEST(JsonText, ListsOfOtherThingsThanNumbersAreNoFloats) {
  const JsonText file(R"({"good": [ 1, -2.5,3e0 ], "none": [], "null": [1, null], "text": ["1"],
                          "nested": [[1]], "number": 3, "odd": [1, NaN], "huge": [1e999]})");
  const JsonObject lists = file.readObject(file.root());
  const auto good = file.readFloats(*lists.find("good"));
  ASSERT_TRUE(good);
  EXPECT_EQ(*good, Embedding(Eigen::Vector3f(1.0F, -2.5F, 3.0F)));
  EXPECT_EQ(file.readFloats(*lists.find("none"))->size(), 0);
  for (const char* name : {"null", "text", "nested", "number", "odd", "huge"}) {
    EXPECT_FALSE(file.readFloats(*lists.find(name))) << name;
  }
}

TEST(JsonText, ErrorsNameLineColumnAndWhatIsWrong) {
  EXPECT_EQ(errorOf("{\n  \"a\": x}"),
            "is not JSON: line 2, column 8: expected a value, found 'x'");
  EXPECT_EQ(errorOf("[1 2]"), "is not JSON: line 1, column 4: expected ',' or ']'");
  EXPECT_EQ(errorOf("[1"),
            "is not JSON or cut off: line 1, column 3: the file ends; expected ',' or ']'");
  EXPECT_EQ(errorOf("{} {}"), "is not JSON: line 1, column 4: expected nothing behind the value");
}

TEST(JsonNumbers, FloatsAreThoseOfStrtodToTheBit) {
  std::mt19937_64 random(3);
  const auto check = [](const std::string& text) {
    float value = 0.0F;
    const char* end = parseNumber(text.c_str(), value);
    ASSERT_EQ(end - text.c_str(), static_cast<std::ptrdiff_t>(text.size())) << text;
    ASSERT_EQ(bitsOf(value), bitsOf(static_cast<float>(std::strtod(text.c_str(), nullptr))))
        << text;
  };
  char text[64];
  for (int i = 0; i < 200'000; ++i) {
    const std::uint64_t bits = random();
    double number = 0.0;
    std::memcpy(&number, &bits, sizeof(number));
    if (!std::isfinite(number) || std::abs(number) > 1e300) continue;
    for (const int digits : {3, 9, 17, 25}) {
      std::snprintf(text, sizeof(text), "%.*e", digits, number);
      check(text);
      std::snprintf(text, sizeof(text), "%.*f", digits,
                    static_cast<double>(random() % 1'000'000) / 999'999.0 - 0.5);
      check(text);
    }
  }
}

TEST(JsonNumbers, NumbersInTheMiddleOfTwoFloatsRoundAsStrtodDoes) {
  std::mt19937 random(4);
  char text[64];
  for (int i = 0; i < 100'000; ++i) {
    const float low = std::ldexp(static_cast<float>(random()), -static_cast<int>(random() % 60));
    const double middle =
        (static_cast<double>(low) + static_cast<double>(std::nextafter(low, 2 * low))) / 2;
    for (const double number :
         {middle, std::nextafter(middle, 0.0), std::nextafter(middle, 1e300)}) {
      std::snprintf(text, sizeof(text), "%.17g", number);
      float value = 0.0F;
      parseNumber(text, value);
      ASSERT_EQ(bitsOf(value), bitsOf(static_cast<float>(number))) << text;
    }
  }
}

TEST(JsonNumbers, WhatIsNoNumberIsLeft) {
  for (const char* text : {"", "-", "x", "null", "\"1\"", "1e999", "]"}) {
    float value = 7.0F;
    EXPECT_EQ(parseNumber(text, value), text);
    EXPECT_EQ(value, 7.0F);
  }
}

TEST(JsonNumbers, WrittenNumbersAreReadAsTheSame) {
  std::mt19937 random(5);
  for (int i = 0; i < 100'000; ++i) {
    const auto bits = static_cast<std::uint32_t>(random());
    float number = 0.0F;
    std::memcpy(&number, &bits, sizeof(number));
    std::string text;
    appendNumber(number, text);
    if (!std::isfinite(number)) {
      ASSERT_EQ(text, "null");
      continue;
    }
    ASSERT_EQ(bitsOf(json::parse(text).get<float>()), bits) << text;
    ASSERT_LE(text.size(), 16U);
    text.clear();
    const double larger = 1e3 * static_cast<double>(number) + 1.0 / 3.0;
    appendNumber(larger, text);
    ASSERT_EQ(json::parse(text).get<double>(), larger);
  }
}

}  // namespace
}  // namespace tsg::scene_graph
