// SPDX-License-Identifier: BSD-3-Clause
// The report on 3 s of a plain room at 160x120, clean and with every fault that can be seen in it.
#include "task_scene_graph/plausibility/input_plausibility.h"

#include <gtest/gtest.h>

#include <limits>

#include "plausibility/depth_findings.h"
#include "rgbd_faults.h"

namespace tsg::plausibility {
namespace {

using test::BoxRoomMotion;
using test::RgbdWalk;
constexpr int kFrames = 30;

std::vector<Finding> report(const RgbdWalk& walk) {
  InputPlausibility plausibility;
  for (const RgbdFrame& frame : walk) plausibility.addFrame(frame);
  return plausibility.findings();
}

std::string toLines(const std::vector<Finding>& findings) {
  std::string lines;
  for (const Finding& finding : findings) lines += "\n  " + toText(finding);
  return lines;
}

/// One finding with this key, of which the text holds `part`, and none with another key.
void expectOnly(const RgbdWalk& walk, const std::string& check, const std::string& part) {
  const auto findings = report(walk);
  ASSERT_EQ(findings.size(), 1U) << toLines(findings);
  EXPECT_EQ(findings[0].check, check);
  EXPECT_NE(toText(findings[0]).find(part), std::string::npos) << toLines(findings);
}

void expectSilence(const RgbdWalk& walk) {
  const auto findings = report(walk);
  EXPECT_TRUE(findings.empty()) << toLines(findings);
}

class EveryMotion : public ::testing::TestWithParam<BoxRoomMotion> {
 protected:
  RgbdWalk walk_ = test::makeBoxRoomWalk(GetParam(), kFrames);
};

TEST_P(EveryMotion, CleanIsSilent) { expectSilence(walk_); }

TEST_P(EveryMotion, CleanIsSilentAfterEachFrame) {
  InputPlausibility plausibility;
  for (const RgbdFrame& frame : walk_) {
    plausibility.addFrame(frame);
    EXPECT_TRUE(plausibility.findings().empty()) << toLines(plausibility.findings());
  }
}

TEST_P(EveryMotion, CleanIsSilentInAWorldWhoseZIsNotUp) {
  const Pose T_camera_world = walk_.front().T_world_camera.inverse();
  expectSilence(test::inWorld(walk_, T_camera_world.linear()));
}

TEST_P(EveryMotion, FarTooLargeOrSmallDepthIsNamedEvenWithoutMotion) {
  for (const double factor : {0.001, 10.0, 1000.0}) {
    const auto findings = report(test::withDepthTimes(walk_, factor));
    EXPECT_TRUE(hasFinding(findings, "depth range") || hasFinding(findings, "depth scale"))
        << factor << toLines(findings);
    EXPECT_NE(toLines(findings).find("input/depth_scale"), std::string::npos);
  }
}

TEST_P(EveryMotion, ImpossiblePoseConventionsAreNamedWhereTheyCanBeSeen) {
  if (GetParam() == BoxRoomMotion::kStill) {
    expectSilence(test::withInversePoses(walk_));
    expectSilence(test::withBodyAxes(walk_));
    expectSilence(test::withOpenglAxes(walk_));
    return;
  }
  expectOnly(test::withInversePoses(walk_), "pose direction", "--poses");
  expectOnly(test::withBodyAxes(walk_), "camera axes", "x forward, y left, z up");
  if (GetParam() == BoxRoomMotion::kSideways) return;  // along its x axis both are the same
  expectOnly(test::withOpenglAxes(walk_), "camera axes", "OpenGL");
}

INSTANTIATE_TEST_SUITE_P(BoxRoom, EveryMotion,
                         ::testing::Values(BoxRoomMotion::kForward, BoxRoomMotion::kTurning,
                                           BoxRoomMotion::kSideways, BoxRoomMotion::kMixed,
                                           BoxRoomMotion::kCircle, BoxRoomMotion::kStill));

class MotionWithTranslation : public EveryMotion {};

TEST_P(MotionWithTranslation, ADepthUnitFiveTimesTooLargeIsNamedWithTheRightOne) {
  RgbdWalk walk = walk_;
  for (RgbdFrame& frame : walk) {  // 0.2 mm per unit, read as millimetres
    cv::Mat units;
    frame.depth.image.convertTo(units, CV_16UC1, 5000.0);
    frame.depth.image = units;
    frame.depth.metres_per_unit = 0.0002;
  }
  expectSilence(walk);
  const auto findings = report(test::withDepthTimes(walk, 5.0));
  ASSERT_EQ(findings.size(), 1U) << toLines(findings);
  EXPECT_EQ(findings[0].check.substr(0, 6), "depth ") << toLines(findings);
  EXPECT_NE(findings[0].remedy.find("0.0002 (TUM datasets"), std::string::npos)
      << toLines(findings);
}

TEST_P(MotionWithTranslation, MetresReadAsFifthsOfThemAreNamed) {
  expectOnly(test::withDepthTimes(walk_, 0.2), "depth scale", "to 1 (metres)");
  expectOnly(test::withDepthTimes(walk_, 0.25), "depth scale", "to 1 (metres)");
}

TEST_P(MotionWithTranslation, TheAxisThatShouldPointDownIsMentioned) {
  expectOnly(test::withBodyAxes(walk_), "camera axes", "y axis never points down in the world");
  expectOnly(test::withBodyAxes(walk_), "camera axes", "set input/camera_frame");
}

TEST_P(MotionWithTranslation, PosesInMillimetresAreNamed) {
  expectOnly(test::withTranslationsTimes(walk_, 1000.0), "pose scale", "not in metres");
}

TEST_P(MotionWithTranslation, TwoFaultsAtOnceAreBothNamed) {
  const auto findings = report(test::withInversePoses(test::withOpenglAxes(walk_)));
  EXPECT_TRUE(hasFinding(findings, "pose direction")) << toLines(findings);
  EXPECT_TRUE(hasFinding(findings, "camera axes")) << toLines(findings);
}

INSTANTIATE_TEST_SUITE_P(BoxRoom, MotionWithTranslation,
                         ::testing::Values(BoxRoomMotion::kForward, BoxRoomMotion::kMixed,
                                           BoxRoomMotion::kCircle));

class InputReport : public ::testing::Test {
 protected:
  RgbdWalk walk_ = test::makeBoxRoomWalk(BoxRoomMotion::kCircle, 60);
};

TEST_F(InputReport, AFocalLengthOfAnotherImageIsNamed) {
  expectOnly(test::withFocalLengthTimes(walk_, 2.0), "intrinsics", "0.5 times as large");
  expectOnly(test::withFocalLengthTimes(walk_, 0.5), "intrinsics", "2 times as large");
  expectOnly(test::withFocalLengthTimes(walk_, 1.5), "intrinsics", "0.67 times as large");
}

TEST_F(InputReport, DistancesAlongRaysAreNamed) {
  expectOnly(test::withRayDistances(walk_), "ray distance", "along the optical axis");
}

TEST_F(InputReport, ImagesThatAreRepeatedWhileThePoseTurnsAreNamed) {
  expectOnly(test::withFrozenDepth(walk_), "frozen images", "repeats an image");
}

TEST_F(InputReport, OnePoseForAllImagesIsNamed) {
  const RgbdWalk walk = test::makeBoxRoomWalk(BoxRoomMotion::kForward, 100);
  expectOnly(test::withConstantPose(walk), "constant pose", "static transform");
}

TEST_F(InputReport, SomebodyBeforeACameraThatStandsStillIsNoFault) {
  const RgbdWalk walk = test::makeBoxRoomWalk(BoxRoomMotion::kStill, 100);
  expectSilence(test::withPerson(walk, 0.3));
  expectSilence(test::withPerson(walk, 0.4));
}

TEST_F(InputReport, OneDepthForAllPixelsIsNamed) {
  expectOnly(test::withConstantDepth(walk_, 1.0F), "constant depth", "1 m, while the camera moves");
}

TEST_F(InputReport, DepthThatIsNearlyAllInvalidIsNamed) {
  expectOnly(test::withoutMostDepth(walk_), "depth range", "are invalid");
}

TEST_F(InputReport, BlackColorIsNamed) {
  expectOnly(test::withBlackColor(walk_), "dark images", "are black");
}

TEST_F(InputReport, PosesOfOtherImagesFitInNoWay) {
  RgbdWalk walk = test::makeBoxRoomWalk(BoxRoomMotion::kCircle, 100);
  RgbdWalk shuffled = walk;
  for (std::size_t i = 0; i < walk.size(); ++i) {
    shuffled[i].T_world_camera = walk[i * 37 % 100].T_world_camera;
  }
  const auto findings = report(shuffled);
  ASSERT_EQ(findings.size(), 1U) << toLines(findings);
  EXPECT_TRUE(findings[0].check == "pose jitter" || findings[0].check == "reprojection")
      << toLines(findings);
}

TEST_F(InputReport, APersonBeforeTheCameraIsNoFault) {
  expectSilence(test::withPerson(walk_, 0.2));
  expectSilence(test::withPerson(walk_, 0.4));
}

TEST_F(InputReport, FrameIdsAndMatchesArePartOfIt) {
  InputPlausibility plausibility;
  for (const RgbdFrame& frame : walk_) plausibility.addFrame(frame);
  plausibility.noteFrameIds({"color_optical", "depth_optical", "color_optical"});
  plausibility.noteMatches({100, 60, 0.03, 0.02});
  const auto findings = plausibility.findings();
  ASSERT_EQ(findings.size(), 2U) << toLines(findings);
  EXPECT_EQ(findings[0].check, "frame ids");
  EXPECT_EQ(findings[1].check, "matching");
}

TEST_F(InputReport, WithoutAnyFrameStillTellsWhatIsKnown) {
  InputPlausibility plausibility;
  EXPECT_TRUE(plausibility.findings().empty());
  plausibility.noteMatches({100, 100, 0.033, 0.02});
  EXPECT_TRUE(hasFinding(plausibility.findings(), "matching"));
}

TEST_F(InputReport, UnusableFramesAreIgnored) {
  InputPlausibility plausibility;
  RgbdFrame frame = walk_.front();
  frame.depth.image = cv::Mat(10, 10, CV_8UC1);
  plausibility.addFrame(frame);
  frame = walk_.front();
  frame.T_world_camera.translation().x() = std::numeric_limits<double>::quiet_NaN();
  plausibility.addFrame(frame);
  frame = walk_.front();
  frame.camera.fx_px = 0.0;
  plausibility.addFrame(frame);
  plausibility.addFrame(RgbdFrame{});
  EXPECT_TRUE(plausibility.findings().empty());
}

TEST_F(InputReport, TinyImagesAreNoTrouble) {
  RgbdWalk walk = walk_;
  for (RgbdFrame& frame : walk) {
    frame.depth.image = frame.depth.image(cv::Rect(0, 0, 2, 1)).clone();
    frame.color.image = frame.color.image(cv::Rect(0, 0, 2, 1)).clone();
    frame.camera = {2, 1, 2.0, 2.0, 0.5, 0.0};
  }
  InputPlausibility plausibility;
  for (const RgbdFrame& frame : walk) plausibility.addFrame(frame);
  EXPECT_FALSE(hasFinding(plausibility.findings(), "reprojection"));
}

TEST_F(InputReport, ABagInALoopIsSilentRoundAfterRound) {
  InputPlausibility plausibility;
  for (int round = 0; round < 3; ++round) {
    for (const RgbdFrame& frame : walk_) plausibility.addFrame(frame);
  }
  EXPECT_TRUE(plausibility.findings().empty()) << toLines(plausibility.findings());
}

TEST_F(InputReport, TheFirstSecondsOfACameraThatStandsStillClaimNothing) {
  RgbdWalk walk = test::makeBoxRoomWalk(BoxRoomMotion::kStill, 30);
  RgbdWalk moving = test::makeBoxRoomWalk(BoxRoomMotion::kCircle, 30);
  InputPlausibility plausibility;
  for (const RgbdFrame& frame : test::withBodyAxes(walk)) plausibility.addFrame(frame);
  EXPECT_TRUE(plausibility.findings().empty());
  for (RgbdFrame& frame : moving) frame.stamp = Stamp{frame.stamp.ns + 3'000'000'000};
  for (const RgbdFrame& frame : test::withBodyAxes(moving)) plausibility.addFrame(frame);
  EXPECT_TRUE(hasFinding(plausibility.findings(), "camera axes"));
}

TEST_F(InputReport, IsTheSameWhenAskedTwice) {
  InputPlausibility plausibility;
  for (const RgbdFrame& frame : test::withDepthTimes(walk_, 0.2)) plausibility.addFrame(frame);
  EXPECT_EQ(toLines(plausibility.findings()), toLines(plausibility.findings()));
}

}  // namespace
}  // namespace tsg::plausibility
