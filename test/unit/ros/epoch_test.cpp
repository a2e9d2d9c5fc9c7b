// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/epoch.h"

#include <gtest/gtest.h>

namespace tsg::ros_interface {
namespace {

using std::chrono::seconds;

const EpochFollower::Clock::time_point kStart{seconds(1000)};

Stamp at(double seconds_) { return Stamp::fromSeconds(seconds_); }

TEST(EpochFollower, ADeclaredEpochIsTheOwnOneAtFirstWhateverItsNumber) {
  EpochFollower follower;
  EXPECT_EQ(follower.follow(7, at(10.0), kStart), 1U);
  EXPECT_EQ(follower.epoch(), 1U);
}

TEST(EpochFollower, WhatTheOtherStageSentBeforeItsJumpIsOfTheEpochBefore) {
  EpochFollower follower;
  follower.follow(1, at(10.0), kStart);
  follower.startEpoch(kStart);
  EXPECT_EQ(follower.follow(1, at(10.1), kStart), 1U);
  EXPECT_EQ(follower.follow(2, at(0.1), kStart), 2U);
  EXPECT_EQ(follower.epoch(), 2U);
}

TEST(EpochFollower, WhatTheOtherStageSentAfterAJumpThatIsNotYetNoticedLiesAhead) {
  EpochFollower follower;
  follower.follow(1, at(10.0), kStart);
  EXPECT_EQ(follower.follow(2, at(0.1), kStart), 2U);
  EXPECT_EQ(follower.epoch(), 1U);
  follower.startEpoch(kStart);
  EXPECT_EQ(follower.follow(2, at(0.2), kStart), follower.epoch());
}

TEST(EpochFollower, AStreamThatDeclaresNoneIsCountedByItsOwnStamps) {
  EpochFollower follower;
  EXPECT_EQ(follower.follow(0, at(10.0), kStart), 1U);
  EXPECT_EQ(follower.follow(0, at(9.9), kStart), 1U);  // a little late: no jump
  EXPECT_EQ(follower.follow(0, at(0.0), kStart), 2U);
  follower.startEpoch(kStart);
  EXPECT_EQ(follower.follow(0, at(0.1), kStart), follower.epoch());
}

TEST(EpochFollower, AStageThatWasStartedAnewIsOfThePresent) {
  EpochFollower follower;
  follower.follow(1, at(1.0), kStart);
  follower.startEpoch(kStart);
  follower.follow(2, at(0.0), kStart);
  EXPECT_EQ(follower.follow(1, at(0.5), kStart), 2U);
}

TEST(EpochFollower, CountsThatDifferForLongAreBroughtTogether) {
  EpochFollower follower(seconds(10));
  follower.follow(1, at(10.0), kStart);
  follower.startEpoch(kStart);
  // The other stage never noticed the jump: no image reached it between.
  EXPECT_EQ(follower.follow(1, at(3.0), kStart + seconds(1)), 1U);
  EXPECT_EQ(follower.follow(1, at(4.0), kStart + seconds(5)), 1U);
  EXPECT_EQ(follower.follow(1, at(12.0), kStart + seconds(13)), 2U);
  EXPECT_EQ(follower.follow(1, at(12.1), kStart + seconds(13)), 2U);
  EXPECT_EQ(follower.follow(2, at(0.0), kStart + seconds(14)), 3U);
}

}  // namespace
}  // namespace tsg::ros_interface
