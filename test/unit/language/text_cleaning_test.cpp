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

TEST(CleanText, DecodesHtmlUpToThreeTimes) {
  // Once while repairing, twice after that.
  EXPECT_EQ(cleanText("&amp;eacute;"), "é");
  EXPECT_EQ(cleanText("&amp;amp;amp;amp;"), "&");
  EXPECT_EQ(cleanText("&unknown; &#xd800;"), "&unknown; \ufffd");
}

TEST(CleanText, TagsKeepQuotationMarksOfReferencesCurly) {
  EXPECT_EQ(cleanText("&lsquo;a&rsquo;"), "'a'");
  EXPECT_EQ(cleanText("<b>&lsquo;a&rsquo;"), "<b>‘a’");
}

TEST(CleanText, ComposesAccentsAndStraightensCharacters) {
  EXPECT_EQ(cleanText("E\u0301 ﬁsh ＡＢＣ “q” it’s"), "é fish abc \"q\" it's");
}

TEST(CleanText, RemovesControlCharactersAndTerminalColours) {
  EXPECT_EQ(cleanText(std::string("a\x00\x07z \x1b[31mred\x1b[0m \ufeff!", 24)), "az red !");
}

TEST(CleanText, IsIdempotentOnCleanText) {
  for (const char* text : {"wash the dishes", "ΟΔΟΣ", "İ", "5 &amp; 6", "日本語　テキスト"}) {
    const std::string clean = cleanText(text);
    EXPECT_EQ(cleanText(clean), clean);
  }
}

TEST(CleanText, InvalidUtf8IsRefused) {
  EXPECT_THROW(cleanText("\xff"), std::invalid_argument);
  EXPECT_THROW(cleanText("\xed\xa0\x80"), std::invalid_argument);  // a surrogate
  EXPECT_THROW(cleanText("\xc0\x80"), std::invalid_argument);      // an overlong zero
}

TEST(SplitWords, SeparatesLettersDigitsAndTheRest) {
  EXPECT_EQ(splitWords("route66 it's a-b!?"),
            Words({"route", "6", "6", "it", "'s", "a", "-", "b", "!?"}));
  EXPECT_EQ(splitWords(""), Words());
}

TEST(SplitWords, CombiningMarksAreNotLetters) {
  EXPECT_EQ(splitWords("q\u0307a x\u0345y"), Words({"q", "\u0307", "a", "x", "y"}));
}

}  // namespace
}  // namespace tsg::language
