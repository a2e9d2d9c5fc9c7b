// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>

#include "synthetic_robot.h"

namespace tsg::test {
namespace {

/// A tracker that lives through everything that is wrong with its input. Each test has stamps of
/// its own, later than those of the tests before.
class InputErrors : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    state_ = new State;
    ASSERT_TRUE(state_->log.waitForPublisher());
    ASSERT_TRUE(load(state_->loader, "tracker", "Tracker"));
  }
  static void TearDownTestSuite() {
    delete state_;
    state_ = nullptr;
  }
  static RobotMessages nextMessages() {
    const int index = state_->num_frames++;
    return makeMessages(index % 20, 100.0 + 10.0 * index);
  }
  static bool expectDropped(const std::string& reason) {
    return waitUntil([&] {
      return findDiagnostics(state_->diagnostics, "tracker").count("dropped: " + reason) > 0;
    });
  }
  static std::uint64_t numProcessed() {
    const auto lines = findDiagnostics(state_->diagnostics, "tracker");
    const auto found = lines.find("processed");
    return found == lines.end() ? 0 : std::stoull(found->second);
  }
  /// The tracker still works: a good frame passes.
  static bool passesGoodFrame() {
    const std::uint64_t before = numProcessed();
    state_->robot->publish(nextMessages());
    return waitUntil([&] { return numProcessed() > before; });
  }

  struct State {
    Recorder<rosgraph_msgs::Log> log{"/rosout"};
    Recorder<diagnostic_msgs::DiagnosticArray> diagnostics{"/diagnostics"};
    nodelet::Loader loader{false};
    std::unique_ptr<Robot> robot;
    int num_frames = 0;
  };
  static State* state_;
};
InputErrors::State* InputErrors::state_ = nullptr;

TEST_F(InputErrors, A_SilentTopicsAreNamedWithTheRemedy) {
  // All of them in one line, and that once: more comes after ten seconds at the earliest.
  std::vector<std::string> parts = {"[/tracker] no messages for "};
  for (const std::string topic : {"/camera/color/image_raw", "/camera/color/camera_info",
                                  "/camera/aligned_depth_to_color/image_raw", "/segmentation"}) {
    parts.push_back(topic + ": nobody publishes it; remap '" + topic.substr(1) + "' to your topic");
  }
  EXPECT_TRUE(waitForLog(state_->log, parts));
  state_->robot = std::make_unique<Robot>();
  ASSERT_TRUE(state_->robot->waitForSubscribers(1));
  ASSERT_TRUE(state_->robot->waitForSegmentationSubscribers(1));
}

TEST_F(InputErrors, B_MissingTransformIsNamed) {
  state_->robot->publish(nextMessages(), false);
  EXPECT_TRUE(
      waitForLog(state_->log, {"no transform from 'camera_color_optical_frame' to 'world'"}));
  EXPECT_TRUE(expectDropped("no transform"));
  EXPECT_TRUE(passesGoodFrame());
}

TEST_F(InputErrors, C_WrongColourEncodingIsNamed) {
  RobotMessages messages = nextMessages();
  messages.color->encoding = "yuv422";
  state_->robot->publish(messages);
  EXPECT_TRUE(waitForLog(state_->log, {"/camera/color/image_raw has encoding 'yuv422', expected "
                                       "rgb8 or bgr8"}));
  EXPECT_TRUE(expectDropped("wrong encoding"));
  EXPECT_TRUE(passesGoodFrame());
}

TEST_F(InputErrors, D_DepthOfAnotherSizeIsNamed) {
  RobotMessages messages = nextMessages();
  messages.depth = ros_interface::toImageMessage(cv::Mat(36, 48, CV_32FC1, cv::Scalar(1.0)),
                                                 "32FC1", messages.stamp, "camera");
  state_->robot->publish(messages);
  EXPECT_TRUE(waitForLog(state_->log, {"/camera/aligned_depth_to_color/image_raw is 48x36",
                                       "/camera/color/image_raw is 96x72"}));
  EXPECT_TRUE(expectDropped("sizes differ"));
  EXPECT_TRUE(passesGoodFrame());
}

TEST_F(InputErrors, E_IntrinsicsThatAreNotFiniteAreNamed) {
  RobotMessages messages = nextMessages();
  messages.info->K[0] = std::numeric_limits<double>::quiet_NaN();
  state_->robot->publish(messages);
  EXPECT_TRUE(waitForLog(state_->log, {"/camera/color/camera_info has K[0] = nan"}));
  EXPECT_TRUE(expectDropped("bad intrinsics"));
  EXPECT_TRUE(passesGoodFrame());
}

TEST_F(InputErrors, F_BrokenSegmentationIsNamed) {
  RobotMessages messages = nextMessages();
  messages.segmentation->embeddings.pop_back();
  state_->robot->publish(messages);
  EXPECT_TRUE(waitForLog(state_->log, {"segmentation on /segmentation has 7 embedding values"}));
  EXPECT_TRUE(expectDropped("unusable segmentation"));
  EXPECT_TRUE(passesGoodFrame());
}

TEST_F(InputErrors, G_DistortionIsWarnedOfAndTheFramePasses) {
  RobotMessages messages = nextMessages();
  messages.info->D = {0.1, 0.0, 0.0, 0.0, 0.0};
  const std::uint64_t before = numProcessed();
  state_->robot->publish(messages);
  EXPECT_TRUE(waitForLog(state_->log, {"/camera/color/camera_info reports a lens distortion"}));
  EXPECT_TRUE(waitUntil([&] { return numProcessed() > before; }));
}

TEST_F(InputErrors, H_ConvertedColourIsCountedAsACopy) {
  EXPECT_EQ(findDiagnostics(state_->diagnostics, "tracker")["images copied"], "0");
  RobotMessages messages = nextMessages();
  messages.color =
      ros_interface::toImageMessage(cv::Mat(72, 96, CV_8UC4, cv::Scalar::all(9)), "bgra8",
                                    messages.stamp, messages.color->header.frame_id);
  state_->robot->publish(messages);
  EXPECT_TRUE(waitUntil(
      [] { return findDiagnostics(state_->diagnostics, "tracker")["images copied"] == "1"; }));
}

TEST_F(InputErrors, MisspeltParameterStopsTheStageAndIsNamed) {
  EXPECT_FALSE(load(state_->loader, "misspelt", "Tracker"));
  EXPECT_TRUE(waitForLog(state_->log, {"[/misspelt] not started", "unknown parameter 'windows_s'",
                                       "did you mean 'window_s'?"}));
}

TEST_F(InputErrors, ParameterOutOfRangeStopsTheStageAndIsNamed) {
  EXPECT_FALSE(load(state_->loader, "out_of_range", "Tracker"));
  EXPECT_TRUE(waitForLog(state_->log, {"[/out_of_range] not started", "'min_pixels' is -5",
                                       "expected a value in [1, "}));
}

TEST_F(InputErrors, SegmenterWithoutModelsSaysWhichParameterToSet) {
  EXPECT_FALSE(load(state_->loader, "silent_segmenter", "Segmenter"));
  EXPECT_TRUE(waitForLog(state_->log, {"'/silent_segmenter/models' is not set",
                                       "models:=", "recorded_segmentation:=true"}));
}

TEST_F(InputErrors, UnreadableModelIsNamed) {
  EXPECT_FALSE(load(state_->loader, "unreadable_model", "Segmenter"));
  EXPECT_TRUE(
      waitForLog(state_->log, {"[/unreadable_model] not started", "/nonexistent/models.yaml"}));
}

TEST_F(InputErrors, MissingTasksAreNamed) {
  EXPECT_FALSE(load(state_->loader, "no_tasks", "SceneGraph"));
  EXPECT_TRUE(waitForLog(state_->log, {"'/no_tasks/object_tasks' is not set"}));
}

}  // namespace
}  // namespace tsg::test

int main(int argc, char** argv) { return tsg::test::runRosTests(argc, argv, "input_errors_test"); }
