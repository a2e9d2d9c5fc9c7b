// SPDX-License-Identifier: BSD-3-Clause
// The report on a real hand-held recording (kitchen: noise, holes, colour and depth not quite
// registered, a world that is its first camera's) and on a rendered walk (house_a).
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "rgbd_faults.h"
#include "support.h"
#include "task_scene_graph/plausibility/input_plausibility.h"

namespace tsg::plausibility {
namespace {

using test::RgbdWalk;

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

void expectSilence(const RgbdWalk& walk, const std::string& what) {
  const auto findings = report(walk);
  EXPECT_TRUE(findings.empty()) << what << toLines(findings);
}

void expectOnly(const RgbdWalk& walk, const std::string& check, const std::string& part) {
  const auto findings = report(walk);
  ASSERT_EQ(findings.size(), 1U) << check << toLines(findings);
  EXPECT_EQ(findings[0].check, check);
  EXPECT_NE(toText(findings[0]).find(part), std::string::npos) << toLines(findings);
}

/// The world whose z axis is opposite to the camera's mean y axis.
RgbdWalk level(const RgbdWalk& walk) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const RgbdFrame& frame : walk) up -= frame.T_world_camera.linear().col(1);
  const auto q = Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ());
  return test::inWorld(walk, q.toRotationMatrix());
}

struct Recording {
  std::string name;
  int num_frames;
  double rate_hz;
};

class Recorded : public ::testing::TestWithParam<Recording> {
 protected:
  /// Every fourth pixel of all frames; read once.
  const RgbdWalk& walk(const std::filesystem::path& folder) {
    static std::map<std::string, RgbdWalk> walks;
    RgbdWalk& found = walks[GetParam().name];
    if (found.empty()) {
      found = test::loadWalk(folder, GetParam().num_frames, GetParam().rate_hz, 1, 160);
    }
    return found;
  }
};

#define LOAD_WALK(variable)                              \
  TSG_REQUIRE_SHARED(folder, "data/" + GetParam().name); \
  const RgbdWalk& variable = walk(folder)

TEST_P(Recorded, AsItIsIsSilentAtEveryStride) {
  LOAD_WALK(all);
  for (const std::size_t stride : {1, 2, 3, 5, 10, 30}) {
    RgbdWalk some;
    for (std::size_t i = 0; i < all.size(); i += stride) some.push_back(all[i]);
    expectSilence(some, "stride " + std::to_string(stride));
  }
}

TEST_P(Recorded, EverySecondOrThreeOfItAreSilent) {
  LOAD_WALK(all);
  for (const std::size_t length : {10U, 30U, 90U}) {
    for (std::size_t first = 0; first < all.size(); first += length) {
      expectSilence(test::cut(all, first, length), std::to_string(first));
    }
  }
}

TEST_P(Recorded, IsSilentInALevelWorldAndInOneThatIsNot) {
  LOAD_WALK(all);
  const RgbdWalk leveled = level(all);
  expectSilence(leveled, "level");
  const Eigen::Vector3d axis(1.0, 1.0, 0.0);
  for (const double angle_rad : {0.7, 1.6, 3.1}) {
    const Eigen::AngleAxisd turn(angle_rad, axis.normalized());
    expectSilence(test::inWorld(leveled, turn.toRotationMatrix()), std::to_string(angle_rad));
  }
}

TEST_P(Recorded, AtFullSizeIsSilent) {
  TSG_REQUIRE_SHARED(folder, "data/" + GetParam().name);
  expectSilence(test::loadWalk(folder, GetParam().num_frames, GetParam().rate_hz, 3, 640), "640");
}

TEST_P(Recorded, SmallPoseNoiseAndPeopleAreSilent) {
  LOAD_WALK(all);
  expectSilence(test::withPoseNoise(all, 0.003, 1), "noise");
  expectSilence(test::withPerson(all, 0.3), "person");
}

TEST_P(Recorded, PoseConventionsAreNamed) {
  LOAD_WALK(all);
  expectOnly(test::withInversePoses(all), "pose direction", "map world to camera");
  expectOnly(test::withOpenglAxes(all), "camera axes", "OpenGL");
  expectOnly(test::withBodyAxes(all), "camera axes", "input/camera_frame");
  expectOnly(test::withMirroredWorld(all), "camera axes", "left-handed");
  expectOnly(test::withTranslationsTimes(all, 1000.0), "pose scale", "not in metres");
}

TEST_P(Recorded, TheMissingDownwardAxisIsMentionedInALevelWorld) {
  LOAD_WALK(all);
  expectOnly(test::withBodyAxes(level(all)), "camera axes", "y axis never points down");
}

TEST_P(Recorded, DepthUnitsAreNamed) {
  LOAD_WALK(all);
  expectOnly(test::withDepthTimes(all, 0.2), "depth scale", "5 times as large");
  expectOnly(test::withDepthTimes(all, 0.25), "depth scale", "4 times as large");
  expectOnly(test::withDepthTimes(all, 4.0), "depth scale", "0.25 times as large");
  expectOnly(test::withDepthTimes(all, 5.0), "depth scale", "0.2 times as large");
  expectOnly(test::withDepthTimes(all, 10.0), "depth scale", "0.1 times as large");
  expectOnly(test::withDepthTimes(all, 1000.0), "depth scale", "0.001 times as large");
  expectOnly(test::withDepthTimes(all, 0.001), "depth scale", "1000 times as large");
}

TEST_P(Recorded, GeometryOfAnotherCameraIsNamed) {
  LOAD_WALK(all);
  for (const double factor : {0.5, 0.65, 1.5, 2.0}) {
    expectOnly(test::withFocalLengthTimes(all, factor), "intrinsics", "focal length");
  }
  expectOnly(test::withRayDistances(all), "ray distance", "(z)");
}

TEST_P(Recorded, LatePosesAreNamed) {
  LOAD_WALK(all);
  const int num_frames = static_cast<int>(std::lround(0.3 * GetParam().rate_hz));
  expectOnly(test::withLatePoses(all, num_frames), "pose delay", "0.3 s later");
}

TEST_P(Recorded, TwoFaultsAtOnceAreBothNamed) {
  LOAD_WALK(all);
  auto findings = report(test::withDepthTimes(test::withOpenglAxes(all), 0.2));
  EXPECT_TRUE(hasFinding(findings, "camera axes")) << toLines(findings);
  EXPECT_TRUE(hasFinding(findings, "depth scale")) << toLines(findings);
  findings = report(test::withInversePoses(test::withBodyAxes(all)));
  EXPECT_TRUE(hasFinding(findings, "camera axes")) << toLines(findings);
  EXPECT_TRUE(hasFinding(findings, "pose direction")) << toLines(findings);
}

INSTANTIATE_TEST_SUITE_P(Sequences, Recorded,
                         ::testing::Values(Recording{"kitchen", 300, 30.0},
                                           Recording{"house_a", 400, 10.0}),
                         [](const auto& recording) { return recording.param.name; });

TEST(RecordedHouse, DepthFromBesideTheColorCameraIsNamed) {
  TSG_REQUIRE_SHARED(folder, "data/house_a");
  const RgbdWalk walk = test::loadWalk(folder, 400, 10.0, 1, 160);
  expectOnly(test::withUnregisteredDepth(walk, 0.06), "registration", "registered");
}

}  // namespace
}  // namespace tsg::plausibility
