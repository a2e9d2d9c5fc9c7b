// SPDX-License-Identifier: BSD-3-Clause
// Two laps through a generated apartment, with odometry that drifts by 3 % of the way.
#include "task_scene_graph/loops/loop_closer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <string>

#include "drifting_walk.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/simulation/depth_noise.h"
#include "task_scene_graph/simulation/renderer.h"
#include "task_scene_graph/simulation/segment_simulator.h"
#include "task_scene_graph/simulation/variation.h"

namespace tsg::loops {
namespace {

using Change = std::function<void(RgbdFrame&)>;

class DriftingApartment : public testing::Test {
 protected:
  DriftingApartment() : walk_(makeDriftingWalk(3, 3, 2, 0.03)) {
    indices_ = selectPoses(walk_, LoopCloserConfig{}.keyframes);
  }

  LoopCloser walk(const LoopCloserConfig& config, bool has_segmentation, const Change& change) {
    const CameraModel camera = simulation::makeDefaultCamera(128, 96);
    const simulation::Renderer renderer(walk_.apartment, 2);
    const simulation::SegmentSimulator segmenter(walk_.apartment, {});
    LoopCloser closer("odom", config);
    for (const std::size_t i : indices_) {
      const auto view = renderer.render(camera, walk_.truth[i].T_world_camera);
      RgbdFrame frame;
      frame.stamp = walk_.odometry[i].stamp;
      frame.camera = camera;
      frame.T_world_camera = walk_.odometry[i].T_world_camera;
      frame.color.image = view.color;
      frame.depth.image = simulation::toMillimetres(view.depth_m, 0.3, 6.0);
      change(frame);
      SegmentationPtr segmentation;
      if (has_segmentation) {
        segmentation = std::make_shared<Segmentation>(
            segmenter.segment(view, frame.stamp, static_cast<std::int64_t>(i)));
      }
      closer.add(frame, segmentation);
    }
    closer.finish();
    return closer;
  }

  double computeError(const trajectory::Keyframes& keyframes) const {
    return computeTrajectoryError(
        walk_, indices_, [&](std::size_t k) { return keyframes.list()[k].T_world_camera; });
  }

  void expectRightLoops(const LoopCloser& closer) const {
    for (const LoopRecord& record : closer.records()) {
      if (!isAccepted(record, closer.graph())) continue;
      const auto truth = [&](trajectory::KeyframeId id) {
        return walk_.truth[indices_[id.value - 1]].T_world_camera;
      };
      const Pose off = (truth(record.a).inverse() * truth(record.b)).inverse() *
                       record.registration.T_target_source;
      EXPECT_LT(off.translation().norm(), 0.2) << record.a.value << " " << record.b.value;
    }
  }

  DriftingWalk walk_;
  std::vector<std::size_t> indices_;
};

TEST_F(DriftingApartment, IsCorrectedByLoopsThatAreRight) {
  const LoopCloser closer = walk({}, true, [](RgbdFrame&) {});
  ASSERT_EQ(closer.keyframes().list().size(), indices_.size());
  const double before_m = computeError(closer.keyframes());
  EXPECT_GT(before_m, 0.15);
  EXPECT_LT(computeError(closer.correctedKeyframes()), 0.4 * before_m);
  expectRightLoops(closer);
}

TEST_F(DriftingApartment, ALoneLoopNeedsThatMuchWasInSight) {
  LoopCloserConfig config;
  config.support.max_chi2 = 0.1;  // hardly one supports another
  const auto countAdded = [&] {
    const LoopCloser closer = walk(config, true, [](RgbdFrame&) {});
    return std::count_if(
        closer.records().begin(), closer.records().end(),
        [](const LoopRecord& record) { return record.outcome == LoopOutcome::kAdded; });
  };
  const auto num_lone = countAdded();
  config.loops.min_lone_share_in_sight = 1.0;
  EXPECT_GT(num_lone, countAdded() + 5);
}

TEST_F(DriftingApartment, WithoutImagesIsCorrectedByItsShape) {
  const LoopCloser closer = walk({}, false, [](RgbdFrame&) {});
  EXPECT_LT(computeError(closer.correctedKeyframes()), 0.5 * computeError(closer.keyframes()));
  expectRightLoops(closer);
}

TEST_F(DriftingApartment, WithoutDepthStaysAsItWas) {
  const LoopCloser closer = walk({}, true, [](RgbdFrame& frame) { frame.depth.image.setTo(0); });
  EXPECT_FALSE(closer.records().empty());
  const auto corrected = closer.correctedKeyframes();
  for (std::size_t k = 0; k < indices_.size(); ++k) {
    EXPECT_TRUE(corrected.list()[k].T_world_camera.isApprox(
        closer.keyframes().list()[k].T_world_camera, 1e-12));
  }
  for (const LoopRecord& record : closer.records()) {
    EXPECT_EQ(record.outcome, LoopOutcome::kLittleOverlap);
    EXPECT_NE(describeOutcome(record, closer.graph()).find("overlap"), std::string::npos);
  }
}

TEST(LoopCloser, RejectsPosesThatAreNoneAndStampsThatGoBack) {
  LoopCloser closer("odom");
  RgbdFrame frame;
  frame.camera = simulation::makeDefaultCamera(16, 12);
  frame.depth.image = cv::Mat::zeros(12, 16, CV_16UC1);
  frame.stamp = {1000};
  closer.add(frame, nullptr);
  frame.stamp = {500};
  EXPECT_THROW(closer.add(frame, nullptr), std::invalid_argument);
  frame.stamp = {2000};
  frame.T_world_camera.translation().x() = std::nan("");
  EXPECT_THROW(closer.add(frame, nullptr), std::invalid_argument);
  EXPECT_EQ(closer.keyframes().list().size(), 1U);
  EXPECT_EQ(closer.graph().keyframes().size(), 1U);
  EXPECT_FALSE(closer.finish());
}

TEST(LoopCloser, OfNoFrameHasNothingToDo) {
  LoopCloser closer("odom");
  EXPECT_FALSE(closer.finish());
  EXPECT_TRUE(closer.records().empty());
  LoopCloserConfig config;
  config.loops.min_overlap = 2.0;
  EXPECT_THROW(LoopCloser("odom", config), config::ConfigError);
}

TEST(LoopCloserConfig, OdometryThatMayDriftMoreIsBelievedLess) {
  const LoopCloserConfig usual = makeLoopCloserConfig({});
  EXPECT_EQ(usual.odometry.position_m, LoopCloserConfig{}.odometry.position_m);
  EXPECT_EQ(usual.graph.odometry_scale, LoopCloserConfig{}.graph.odometry_scale);
  LoopConfig loops;
  loops.max_drift = 0.1;
  const LoopCloserConfig worse = makeLoopCloserConfig(loops);
  EXPECT_EQ(worse.loops.max_drift, 0.1);
  EXPECT_DOUBLE_EQ(worse.odometry.position_m, 2.0 * usual.odometry.position_m);
  EXPECT_DOUBLE_EQ(worse.odometry.angle_rad, 2.0 * usual.odometry.angle_rad);
  EXPECT_DOUBLE_EQ(worse.graph.odometry_turn_rad_per_m, 2.0 * usual.graph.odometry_turn_rad_per_m);
  loops.max_drift = 0.0;  // a graph needs some
  EXPECT_DOUBLE_EQ(makeLoopCloserConfig(loops).odometry.angle_rad, 0.2 * usual.odometry.angle_rad);
}

TEST(LoopCloserConfig, AShareThatIsNoneIsNamedAndNotWhatFollowsFromIt) {
  for (const double share : {2.0, -0.1, std::numeric_limits<double>::quiet_NaN()}) {
    LoopConfig loops;
    loops.max_drift = share;
    try {
      makeLoopCloserConfig(loops);
      ADD_FAILURE() << share;
    } catch (const config::ConfigError& e) {
      EXPECT_NE(std::string(e.what()).find("max_drift"), std::string::npos) << e.what();
    }
  }
}

}  // namespace
}  // namespace tsg::loops
