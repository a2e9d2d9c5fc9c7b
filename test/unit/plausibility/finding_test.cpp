// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/plausibility/finding.h"

#include <gtest/gtest.h>

namespace tsg::plausibility {
namespace {

TEST(Finding, IsOneLineOfText) {
  EXPECT_EQ(toText({"depth range", "median 0.2 m", "usually the unit", "set depth_scale"}),
            "depth range: median 0.2 m; usually the unit; set depth_scale");
}

TEST(Finding, SharesNearTheEndsAreNotRoundedToThem) {
  EXPECT_EQ(formatShare(0.0), "0 %");
  EXPECT_EQ(formatShare(0.001), "under 1 %");
  EXPECT_EQ(formatShare(0.973), "97 %");
  EXPECT_EQ(formatShare(0.999), "over 99 %");
  EXPECT_EQ(formatShare(1.0), "100 %");
}

TEST(Finding, NumbersHaveThreeDigitsAndLargeOnesNoExponent) {
  EXPECT_EQ(formatNumber(0.0002), "0.0002");
  EXPECT_EQ(formatNumber(0.38283), "0.383");
  EXPECT_EQ(formatNumber(2512.3), "2512");
}

TEST(Finding, IsFoundByItsKey) {
  const std::vector<Finding> findings{{"matching", "", "", ""}};
  EXPECT_TRUE(hasFinding(findings, "matching"));
  EXPECT_FALSE(hasFinding(findings, "depth range"));
}

}  // namespace
}  // namespace tsg::plausibility
