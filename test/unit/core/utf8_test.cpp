// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/utf8.h"

#include <gtest/gtest.h>

namespace tsg {
namespace {

TEST(Utf8, WellFormedTextsOfAllLengthsAreValid) {
  for (const char* text :
       {"", "wash", "\xc3\xa9", "\xe6\xb4\x97", "\xf0\x9f\xa4\x96", "\xed\x9f\xbf", "\xee\x80\x80",
        "\xf4\x8f\xbf\xbf", "\xc2\x80", "\xe0\xa0\x80"}) {
    EXPECT_TRUE(isValidUtf8(text)) << text;
  }
}

TEST(Utf8, OverlongSurrogateTooLargeAndTruncatedTextsAreNot) {
  for (const char* text :
       {"\xff", "caf\xe9", "\x80", "\xc0\x80", "\xc1\xbf", "\xe0\x9f\xbf", "\xed\xa0\x80",
        "\xf0\x8f\xbf\xbf", "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xc3", "\xe6\xb4",
        "\xf0\x9f\xa4", "\xc3(", "\xe6(\x97"}) {
    EXPECT_FALSE(isValidUtf8(text)) << text;
  }
}

}  // namespace
}  // namespace tsg
