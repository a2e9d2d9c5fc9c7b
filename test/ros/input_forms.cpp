// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/CompressedImage.h>

#include <cstring>
#include <opencv2/imgcodecs.hpp>

#include "synthetic_robot.h"

namespace tsg::test {
namespace {

constexpr int kNumFrames = 12;

/// Publishes one form of input on topics of its own, and looks at what the tracker of that name
/// makes of it.
class InputForms : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    state_ = new State;
    ASSERT_TRUE(state_->log.waitForPublisher());
  }
  static void TearDownTestSuite() {
    delete state_;
    state_ = nullptr;
  }

  void start(const std::string& name) {
    name_ = name;
    ASSERT_TRUE(load(state_->loader, name, "Tracker"));
    color_ = advertise<sensor_msgs::Image>("color");
    depth_ = advertise<sensor_msgs::Image>("depth");
    segmentation_ = advertise<msg::Segmentation>("segmentation");
    waitFor(color_);
    waitFor(depth_);
    waitFor(segmentation_);
  }
  template <typename Message>
  ros::Publisher advertise(const std::string& topic, bool is_latched = false) {
    return state_->handle.advertise<Message>("/" + name_ + "/" + topic, 100, is_latched);
  }
  static void waitFor(const ros::Publisher& publisher) {
    ASSERT_TRUE(waitUntil([&] { return publisher.getNumSubscribers() > 0; }))
        << publisher.getTopic();
  }
  void publishImages(const RobotMessages& messages) {
    color_.publish(sensor_msgs::ImageConstPtr(messages.color));
    depth_.publish(sensor_msgs::ImageConstPtr(messages.depth));
    segmentation_.publish(msg::SegmentationConstPtr(messages.segmentation));
  }
  /// Transforms around all the frames' stamps.
  static void publishTransforms() {
    for (int i = -1; i <= kNumFrames; ++i) {
      state_->tf.sendTransform(makeMessages(i).transform);
    }
  }
  std::uint64_t read(const std::string& key) const {
    const auto lines = findDiagnostics(state_->diagnostics, name_);
    const auto found = lines.find(key);
    return found == lines.end() ? 0 : std::stoull(found->second);
  }
  bool waitForValue(const std::string& key, std::uint64_t value) const {
    return waitUntil([&] { return read(key) == value; });
  }

  struct State {
    ros::NodeHandle handle;
    Recorder<rosgraph_msgs::Log> log{"/rosout"};
    Recorder<diagnostic_msgs::DiagnosticArray> diagnostics{"/diagnostics"};
    nodelet::Loader loader{false};
    tf2_ros::TransformBroadcaster tf;
  };
  static State* state_;
  std::string name_;
  ros::Publisher color_;
  ros::Publisher depth_;
  ros::Publisher segmentation_;
};
InputForms::State* InputForms::state_ = nullptr;

TEST_F(InputForms, OneCameraInfoHoldsForAllImagesEvenThoseBefore) {
  start("latched");
  publishTransforms();
  for (int i = 0; i < kNumFrames; ++i) {
    publishImages(makeMessages(i));
    if (i != 4) continue;
    auto info = advertise<sensor_msgs::CameraInfo>("info", true);
    waitFor(info);
    info.publish(sensor_msgs::CameraInfoConstPtr(makeMessages(i).info));
  }
  EXPECT_TRUE(waitForValue("processed", kNumFrames)) << read("processed");
}

TEST_F(InputForms, OdometryNeedsNeitherTfNorCameraInfo) {
  start("odometry");
  auto pose = advertise<nav_msgs::Odometry>("pose");
  waitFor(pose);
  for (int i = 0; i < kNumFrames; ++i) {
    const RobotMessages messages = makeMessages(i);
    nav_msgs::Odometry odometry;
    odometry.header = messages.transform.header;
    odometry.child_frame_id = messages.transform.child_frame_id;
    odometry.pose.pose.position.x = messages.transform.transform.translation.x;
    odometry.pose.pose.position.y = messages.transform.transform.translation.y;
    odometry.pose.pose.position.z = messages.transform.transform.translation.z;
    odometry.pose.pose.orientation = messages.transform.transform.rotation;
    publishImages(messages);
    pose.publish(odometry);
  }
  EXPECT_TRUE(waitForValue("processed", kNumFrames)) << read("processed");
}

sensor_msgs::CompressedImage compress(const sensor_msgs::Image& image) {
  sensor_msgs::CompressedImage compressed;
  compressed.header = image.header;
  const cv::Mat pixels(static_cast<int>(image.height), static_cast<int>(image.width), CV_8UC3,
                       const_cast<std::uint8_t*>(image.data.data()));
  compressed.format = "rgb8; png compressed bgr8";
  cv::imencode(".png", pixels, compressed.data);
  return compressed;
}

/// Metres as 16UC1 millimetres.
sensor_msgs::CompressedImage compressDepth(const sensor_msgs::Image& image) {
  sensor_msgs::CompressedImage compressed;
  compressed.header = image.header;
  const cv::Mat metres(static_cast<int>(image.height), static_cast<int>(image.width), CV_32FC1,
                       const_cast<std::uint8_t*>(image.data.data()));
  cv::Mat millimetres;
  metres.convertTo(millimetres, CV_16UC1, 1000.0);
  std::vector<std::uint8_t> png;
  cv::imencode(".png", millimetres, png);
  compressed.format = "16UC1; compressedDepth";
  compressed.data.assign(12, 0);
  compressed.data.insert(compressed.data.end(), png.begin(), png.end());
  return compressed;
}

TEST_F(InputForms, CompressedTopicsAreFoundWhereNobodyPublishesRawOnes) {
  name_ = "compressed";
  auto color = advertise<sensor_msgs::CompressedImage>("color/compressed");
  auto depth = advertise<sensor_msgs::CompressedImage>("depth/compressedDepth");
  ASSERT_TRUE(load(state_->loader, name_, "Tracker"));
  segmentation_ = advertise<msg::Segmentation>("segmentation");
  waitFor(color);
  waitFor(depth);
  waitFor(segmentation_);
  EXPECT_TRUE(waitForLog(state_->log, {"/compressed/color/compressed is there"}));
  publishTransforms();
  for (int i = 0; i < kNumFrames; ++i) {
    const RobotMessages messages = makeMessages(i);
    color.publish(compress(*messages.color));
    depth.publish(compressDepth(*messages.depth));
    segmentation_.publish(msg::SegmentationConstPtr(messages.segmentation));
  }
  EXPECT_TRUE(waitForValue("processed", kNumFrames)) << read("processed");
  EXPECT_EQ(read("images copied"), 2U * kNumFrames);
}

TEST_F(InputForms, BadStampsAndImagesWithoutAPartnerAreCountedAndNamed) {
  start("bad_stamps");
  auto info = advertise<sensor_msgs::CameraInfo>("info", true);
  waitFor(info);
  info.publish(sensor_msgs::CameraInfoConstPtr(makeMessages(0).info));
  publishTransforms();
  for (int i = 0; i < kNumFrames; ++i) {
    RobotMessages messages = makeMessages(i);
    if (i == 3) messages.color->header.stamp = ros::Time();
    if (i == 5) messages.color->header.stamp = ros::Time(4294967295U, 0);
    if (i == 7) messages.depth->header.stamp += ros::Duration(0.033);
    publishImages(messages);
  }
  EXPECT_TRUE(waitForValue("processed", kNumFrames - 3)) << read("processed");
  EXPECT_TRUE(waitForValue("dropped: stamp is 0", 1));
  EXPECT_TRUE(waitForValue("dropped: stamp out of range", 1));
  EXPECT_TRUE(waitForValue("dropped: no depth image", 1));
  EXPECT_TRUE(waitForLog(state_->log, {"/bad_stamps/color has stamp 0"}));
  EXPECT_TRUE(waitForLog(state_->log, {"0.033 s away", "input/sync_tolerance_s"}));
}

TEST_F(InputForms, SettingsThatCannotHoldStopTheStage) {
  EXPECT_FALSE(load(state_->loader, "contradiction", "Tracker"));
  EXPECT_TRUE(
      waitForLog(state_->log, {"[/contradiction] not started", "pose_topic", "trajectory"}));
  EXPECT_FALSE(load(state_->loader, "no_file", "Tracker"));
  EXPECT_TRUE(waitForLog(state_->log, {"[/no_file] not started", "/nonexistent/camera.yaml"}));
}

}  // namespace
}  // namespace tsg::test

int main(int argc, char** argv) { return tsg::test::runRosTests(argc, argv, "input_forms_test"); }
