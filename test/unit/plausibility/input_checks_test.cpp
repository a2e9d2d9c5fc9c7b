// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/plausibility/input_checks.h"

#include <gtest/gtest.h>

namespace tsg::plausibility {
namespace {

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(FrameIds, EqualOnesAreSilentWithOrWithoutASlash) {
  EXPECT_TRUE(checkFrameIds({"camera", "camera", "camera"}).empty());
  EXPECT_TRUE(checkFrameIds({"/camera", "camera", "/camera"}).empty());
}

TEST(FrameIds, UnknownOnesAreSilent) {
  EXPECT_TRUE(checkFrameIds({}).empty());
  EXPECT_TRUE(checkFrameIds({"camera", "", ""}).empty());
}

TEST(FrameIds, AnotherDepthFrameIsNamedBesideThatOfColor) {
  const auto findings = checkFrameIds({"color_optical", "depth_optical", "color_optical"});
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].check, "frame ids");
  EXPECT_TRUE(contains(findings[0].seen, "'depth_optical'"));
  EXPECT_TRUE(contains(findings[0].seen, "'color_optical'"));
  EXPECT_TRUE(contains(findings[0].remedy, "aligned_depth_to_color"));
}

TEST(FrameIds, AnotherFrameOfCameraInfoIsNamed) {
  const auto findings = checkFrameIds({"color", "color", "infrared"});
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].check, "camera_info frame");
  EXPECT_TRUE(contains(findings[0].seen, "camera_info is stamped 'infrared', colour 'color'"));
}

TEST(FrameIds, TheDepthCamerasInfoWithItsImagesIsOneLine) {
  EXPECT_EQ(checkFrameIds({"color", "depth", "depth"}).size(), 1U);
  EXPECT_EQ(checkFrameIds({"color", "depth", "infrared"}).size(), 2U);
}

TEST(Matches, AllOrNearlyAllMatchedIsSilent) {
  EXPECT_FALSE(checkMatches({}).has_value());
  EXPECT_FALSE(checkMatches({300, 0, std::nullopt, 0.02}).has_value());
  EXPECT_FALSE(checkMatches({300, 50, 0.033, 0.02}).has_value());
  EXPECT_FALSE(checkMatches({10, 10, 0.033, 0.02}).has_value());
}

TEST(Matches, NoMatchTellsTheDistanceAndTheToleranceToSet) {
  const auto finding = checkMatches({150, 150, 0.033, 0.02});
  ASSERT_TRUE(finding.has_value());
  EXPECT_EQ(finding->check, "matching");
  EXPECT_TRUE(contains(finding->seen, "150 of 150"));
  EXPECT_TRUE(contains(finding->seen, "within 20 ms; the smallest distance found is 33 ms"));
  EXPECT_TRUE(contains(finding->remedy, "input/sync_tolerance_s"));
  EXPECT_TRUE(contains(finding->remedy, "0.04"));
}

TEST(Matches, StampsOfAnotherClockAreNotToBeTolerated) {
  const auto finding = checkMatches({150, 150, 1.5e9, 0.02});
  ASSERT_TRUE(finding.has_value());
  EXPECT_FALSE(contains(finding->remedy, "sync_tolerance"));
  EXPECT_TRUE(contains(finding->remedy, "clock"));
  EXPECT_TRUE(checkMatches({150, 150, std::nullopt, 0.02}).has_value());
}

TEST(Matches, HalfMatchedIsTakenForARateBelowThatOfColor) {
  const auto finding = checkMatches({150, 53, 0.033, 0.02});
  ASSERT_TRUE(finding.has_value());
  EXPECT_TRUE(contains(finding->seen, "53 of 150 colour images (35 %)"));
  EXPECT_TRUE(contains(finding->meaning, "lower rate"));
}

TEST(Intrinsics, UsualCamerasAreSilent) {
  EXPECT_FALSE(checkIntrinsics({640, 480, 525, 525, 319.5, 239.5}).has_value());
  EXPECT_FALSE(checkIntrinsics({640, 480, 615, 615, 328, 242}).has_value());
  EXPECT_FALSE(checkIntrinsics({1280, 720, 637, 637, 641, 362}).has_value());
  EXPECT_FALSE(checkIntrinsics({1296, 968, 1170, 1170, 647, 483}).has_value());
  EXPECT_FALSE(checkIntrinsics({256, 192, 212, 212, 127, 95}).has_value());
  EXPECT_FALSE(checkIntrinsics({96, 72, 75, 75, 47.5, 35.5}).has_value());
}

TEST(Intrinsics, OfAnotherResolutionAreNamed) {
  const auto finding = checkIntrinsics({320, 240, 525, 525, 319.5, 239.5});
  ASSERT_TRUE(finding.has_value());
  EXPECT_EQ(finding->check, "intrinsics");
  EXPECT_TRUE(contains(finding->seen, "320x240"));
  EXPECT_TRUE(contains(finding->seen, "cx 320"));
  EXPECT_TRUE(checkIntrinsics({1280, 960, 525, 525, 319.5, 239.5}).has_value());
}

TEST(Intrinsics, ExchangedNumbersAreNamed) {
  EXPECT_TRUE(checkIntrinsics({640, 480, 525, 525, 239.5, 319.5}).has_value());
  EXPECT_TRUE(checkIntrinsics({640, 480, 319.5, 239.5, 525, 525}).has_value());
  EXPECT_TRUE(checkIntrinsics({640, 480, 1.0, 1.0, 319.5, 239.5}).has_value());
}

}  // namespace
}  // namespace tsg::plausibility
