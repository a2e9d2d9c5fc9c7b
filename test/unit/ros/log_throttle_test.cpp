// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/log_throttle.h"

#include <gtest/gtest.h>

#include <vector>

namespace tsg::ros_interface {
namespace {

LogThrottle::Time at(int seconds) { return LogThrottle::Time{} + std::chrono::seconds(seconds); }

TEST(LogThrottle, AProblemThatStaysIsSaidAgainAfterTwiceTheTimeEachTime) {
  LogThrottle throttle;
  std::vector<int> said;
  for (int t = 1000; t < 2000; ++t) {
    if (throttle.admit("topics", "silent", at(t))) said.push_back(t - 1000);
  }
  EXPECT_EQ(said, (std::vector<int>{0, 10, 30, 70, 150, 310, 630, 950}));
}

TEST(LogThrottle, AProblemThatChangesIsSaidEveryTenSecondsWithWhatWasLeftUnsaid) {
  LogThrottle throttle;
  std::vector<std::uint64_t> unsaid;
  for (int t = 0; t <= 30; ++t) {
    if (const auto count = throttle.admit("pose", std::to_string(t), at(1000 + t))) {
      unsaid.push_back(*count);
    }
  }
  EXPECT_EQ(unsaid, (std::vector<std::uint64_t>{0, 9, 9, 9}));
}

TEST(LogThrottle, AnotherTextOrAnotherKeyDoesNotWaitForTheOneBefore) {
  LogThrottle throttle;
  for (int t = 0; t < 100; ++t) throttle.admit("topics", "silent", at(t));
  EXPECT_TRUE(throttle.admit("topics", "one is silent", at(100)).has_value());
  EXPECT_TRUE(throttle.admit("clock", "silent", at(100)).has_value());
}

TEST(LogThrottle, AProblemThatWasAwayIsNew) {
  LogThrottle throttle;
  for (int t = 0; t < 200; ++t) throttle.admit("topics", "silent", at(t));
  EXPECT_FALSE(throttle.admit("topics", "silent", at(210)).has_value());
  EXPECT_TRUE(throttle.admit("topics", "silent", at(231)).has_value());
}

}  // namespace
}  // namespace tsg::ros_interface
