// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/loops/loop_support.h"

#include <gtest/gtest.h>

#include "graph_worlds.h"
#include "task_scene_graph/config/config.h"

namespace tsg::loops {
namespace {

using trajectory::EdgeKind;
using trajectory::makePose;
using trajectory::PoseEdge;

/// Two laps over the same line, a keyframe each metre: 1 to 40, and 41 to 80 beside them; the
/// second one drifted by 1 m to the side.
class TwoLines : public testing::Test {
 protected:
  TwoLines() {
    for (int i = 0; i < 40; ++i) keyframes_.add({i + 1}, makePose(i, 0.0, 0.0));
    for (int i = 0; i < 40; ++i) keyframes_.add({i + 41}, makePose(i, 1.0, 0.0));
  }
  PoseEdge makeLoop(std::uint64_t a, std::uint64_t b, double off_m = 0.0) const {
    const double along_m = static_cast<double>(b) - 40.0 - static_cast<double>(a);
    return trajectory::makeEdge(a, b, makePose(along_m, off_m, 0.0), EdgeKind::kLoop,
                                trajectory::makeInformation(0.05, 0.01));
  }
  trajectory::Keyframes keyframes_{"odom"};
  LoopSupport support_{keyframes_, {0.06, 0.006}, {}};
};

TEST_F(TwoLines, LoopsThatSayTheSameAgreeWhicheverWayTheyAreAsked) {
  EXPECT_TRUE(support_.doAgree(makeLoop(10, 50), makeLoop(12, 52)));
  EXPECT_TRUE(support_.doAgree(makeLoop(12, 52), makeLoop(10, 50)));
  EXPECT_TRUE(support_.doAgree(makeLoop(12, 50), makeLoop(10, 52)));
}

TEST_F(TwoLines, ThatOdometryDriftedBetweenTheLapsDoesNotMatter) {
  EXPECT_TRUE(support_.doAgree(makeLoop(10, 50, 0.0), makeLoop(12, 52, 0.0)));
  EXPECT_TRUE(support_.doAgree(makeLoop(10, 50, 3.0), makeLoop(12, 52, 3.0)));
  EXPECT_FALSE(support_.doAgree(makeLoop(10, 50, 0.0), makeLoop(12, 52, 3.0)));
}

TEST_F(TwoLines, FarAlongTheWayNoneSupportsAnother) {
  EXPECT_TRUE(support_.doAgree(makeLoop(10, 50), makeLoop(16, 56)));
  EXPECT_FALSE(support_.doAgree(makeLoop(10, 50), makeLoop(17, 57)));
  EXPECT_FALSE(support_.doAgree(makeLoop(10, 50), makeLoop(10, 57)));
}

TEST_F(TwoLines, OneNeedsAnotherBetweenOtherKeyframes) {
  const PoseEdge loop = makeLoop(10, 50);
  EXPECT_FALSE(support_.isSupported(loop, {}));
  EXPECT_FALSE(support_.isSupported(loop, {loop, makeLoop(30, 70)}));
  EXPECT_TRUE(support_.isSupported(loop, {loop, makeLoop(11, 51)}));
  SupportConfig none;
  none.max_way_m = 0.0;
  EXPECT_TRUE(LoopSupport(keyframes_, {}, none).isSupported(loop, {}));
}

TEST_F(TwoLines, OutOfRangeIsRejected) {
  SupportConfig config;
  config.max_chi2 = 0.0;
  EXPECT_THROW(LoopSupport(keyframes_, {}, config), config::ConfigError);
}

}  // namespace
}  // namespace tsg::loops
