// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/language/text_cleaning.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace tsg::language {
namespace {

using Words = std::vector<std::string>;

TEST(CleanText, CollapsesWhiteSpaceAndLowers) {
  EXPECT_EQ(cleanText("  Get\tMY \u00a0\u3000 notes\r\n"), "get my notes");
  EXPECT_EQ(cleanText(" \n\t"), "");
}

TEST(CleanText, StraightensQuotationMarks) {
  EXPECT_EQ(cleanText("It\u2019s \u201ca\u201d \u2018b\u2019"), "it's \"a\" 'b'");
}

TEST(CleanText, LowersLettersOfManyScripts) {
  EXPECT_EQ(cleanText("\u00c9 \u0141\u00d3D\u0179 \u041c\u0418\u0420 \u0391\u03a9 \U00010400"),
            "\u00e9 \u0142\u00f3d\u017a \u043c\u0438\u0440 \u03b1\u03c9 \U00010428");
}

TEST(CleanText, DamageOfTextsFromTheWebIsNotRepaired) {
  for (const char* text : {"salt &amp; pepper", "<b>", "e\u0301", "\ufb01sh"}) {
    EXPECT_EQ(cleanText(text), text);
  }
}

TEST(CleanText, IsIdempotentOnCleanText) {
  for (const char* text : {"wash the dishes", "ΟΔΟΣ", "5 & 6", "日本語　テキスト"}) {
    const std::string clean = cleanText(text);
    EXPECT_EQ(cleanText(clean), clean);
  }
}

TEST(CleanText, InvalidUtf8IsRefused) {
  EXPECT_THROW(cleanText("\xff"), std::invalid_argument);
  EXPECT_THROW(cleanText("\xed\xa0\x80"), std::invalid_argument);  // a surrogate
  EXPECT_THROW(cleanText("\xc0\x80"), std::invalid_argument);      // an overlong zero
  EXPECT_THROW(cleanText("\xe0\x9f\xbf"), std::invalid_argument);  // an overlong U+07FF
  EXPECT_THROW(cleanText("\xf0\x8f\xbf\xbf"), std::invalid_argument);
  EXPECT_THROW(cleanText("\xf4\x90\x80\x80"), std::invalid_argument);  // U+110000
  EXPECT_THROW(cleanText("\xe2\x82"), std::invalid_argument);          // ends too early
  EXPECT_THROW(cleanText("\xe2\x82 a"), std::invalid_argument);
  EXPECT_THROW(cleanText("\x80"), std::invalid_argument);
}

TEST(SplitWords, SeparatesLettersDigitsAndTheRest) {
  EXPECT_EQ(splitWords("route66 it's a-b!?"),
            Words({"route", "6", "6", "it", "'s", "a", "-", "b", "!?"}));
  EXPECT_EQ(splitWords(""), Words());
}

TEST(SplitWords, CombiningMarksAreNotLetters) {
  EXPECT_EQ(splitWords("q\u0307a"), Words({"q", "\u0307", "a"}));
}

TEST(SplitWords, ContractionsAndMarksBeginWordsAnywhereButWithinSymbols) {
  EXPECT_EQ(splitWords("!!'s don''t"), Words({"!!'", "s", "don", "''", "t"}));
  EXPECT_EQ(splitWords("a<end_of_text>b"), Words({"a", "<end_of_text>", "b"}));
  EXPECT_EQ(splitWords("<end_of_text"), Words({"<", "end", "_", "of", "_", "text"}));
}

TEST(SplitWords, EveryCharacterIsInAWordOnce) {
  const std::string text = "caf\u00e9\u20ac42\u0301\U0001f600-x";
  std::string joined;
  for (const std::string& word : splitWords(text)) joined += word;
  EXPECT_EQ(joined, text);
}

}  // namespace
}  // namespace tsg::language
