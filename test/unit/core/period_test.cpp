// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/period.h"

#include <gtest/gtest.h>

namespace tsg {
namespace {

bool isDueAfter(double last_s, double now_s) {
  return isDue(Stamp::fromSeconds(last_s), Stamp::fromSeconds(now_s), 1.0);
}

TEST(Period, WhatWasNeverDoneIsDue) {
  EXPECT_TRUE(isDue(std::nullopt, Stamp::fromSeconds(100.0), 1.0));
}

TEST(Period, IsDueAfterAPeriodAndWhenStampsHaveJumpedBack) {
  EXPECT_FALSE(isDueAfter(100.0, 100.5));
  EXPECT_TRUE(isDueAfter(100.0, 101.0));
  EXPECT_TRUE(isDueAfter(100.0, 3.0));
  EXPECT_FALSE(isDueAfter(3.0, 3.5));
}

}  // namespace
}  // namespace tsg
