// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/CompressedImage.h>

#include <algorithm>
#include <cstring>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "synthetic_robot.h"
#include "task_scene_graph/ros/mesh_update_conversions.h"

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
    ASSERT_TRUE(loadTracker(name));
    color_ = advertise<sensor_msgs::Image>("color");
    depth_ = advertise<sensor_msgs::Image>("depth");
    segmentation_ = advertise<msg::Segmentation>("segmentation");
    waitFor(color_);
    waitFor(depth_);
    waitFor(segmentation_);
  }
  virtual bool loadTracker(const std::string& name) {
    return load(state_->loader, name, "Tracker");
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

cv::Mat viewPixels(sensor_msgs::Image& image, int type) {
  return {static_cast<int>(image.height), static_cast<int>(image.width), type, image.data.data(),
          image.step};
}

/// Each pixel of an image with lens distortion gets what the ideal camera sees in its direction.
void distort(RobotMessages& messages, const std::vector<double>& distortion) {
  messages.info->distortion_model = "plumb_bob";
  messages.info->D = distortion;
  const cv::Mat K(3, 3, CV_64F, messages.info->K.data());
  const cv::Size size(static_cast<int>(messages.color->width),
                      static_cast<int>(messages.color->height));
  std::vector<cv::Point2f> raw;
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      raw.emplace_back(static_cast<float>(u), static_cast<float>(v));
    }
  }
  std::vector<cv::Point2f> ideal;
  cv::undistortPoints(raw, ideal, K, distortion, cv::noArray(), K);
  const cv::Mat source(size, CV_32FC2, ideal.data());
  for (auto& [image, type] : {std::pair{&*messages.color, CV_8UC3},
                              {&*messages.depth, CV_32FC1},
                              {&messages.segmentation->labels, CV_16UC1}}) {
    cv::Mat pixels = viewPixels(*image, type);
    cv::remap(pixels.clone(), pixels, source, cv::noArray(), cv::INTER_NEAREST);
  }
}

/// What a tracker and a mesh_fusion of one name make of the frames.
class InputFormsOfTheMap : public InputForms {
 protected:
  void startChain(const std::string& name) {
    for (const char* topic : {"tracks", "mesh_blocks", "object_primitives", "place_graph"}) {
      remappings_[std::string("/") + topic] = "/" + name + "/" + topic;
    }
    mesh_ = std::make_unique<Recorder<msg::MeshUpdate>>("/" + name + "/mesh_blocks");
    primitives_ =
        std::make_unique<Recorder<msg::ObjectPrimitives>>("/" + name + "/object_primitives");
    start(name);
    ASSERT_TRUE(
        state_->loader.load("/" + name + "_mesh", "task_scene_graph/MeshFusion", remappings_, {}));
    info_ = advertise<sensor_msgs::CameraInfo>("info", true);
    waitFor(info_);  // subscribers of one process share one connection
    ASSERT_TRUE(mesh_->waitForPublisher());
    ASSERT_TRUE(primitives_->waitForPublisher());
  }
  /// start() waits for one subscriber and loads the tracker, which must have the remappings, too.
  bool loadTracker(const std::string& name) override {
    return state_->loader.load("/" + name, "task_scene_graph/Tracker", remappings_, {});
  }
  void play(const std::function<void(RobotMessages&)>& change) {
    publishTransforms();
    for (int i = 0; i < kNumFrames; ++i) {
      RobotMessages messages = makeMessages(i);
      change(messages);
      info_.publish(sensor_msgs::CameraInfoConstPtr(messages.info));
      publishImages(messages);
    }
    ASSERT_TRUE(waitForValue("processed", kNumFrames)) << read("processed");
    msg::Flush flush;
    flush.request.mode = msg::FlushRequest::END;
    ASSERT_TRUE(ros::service::call("/" + name_ + "/flush", flush));
    ASSERT_TRUE(flush.response.success) << flush.response.missing.front();
    flush.request.sequence = flush.response.sequence;
    ASSERT_TRUE(ros::service::call("/" + name_ + "_mesh/flush", flush));
    ASSERT_TRUE(flush.response.success) << flush.response.missing.front();
    const Stamp newest = makeMessages(kNumFrames - 1).stamp;
    ASSERT_TRUE(mesh_->waitFor([&](const msg::MeshUpdate& update) {
      return ros_interface::toStamp(update.header.stamp) == newest;
    }));
  }
  /// Distances of the mesh's vertices to the nearest surface of the room, in order.
  std::vector<double> computeErrors() const {
    ros_interface::MeshUpdateReader reader;
    for (const auto& update : mesh_->messages()) reader.apply(*update);
    const auto room = makeRoom();
    std::vector<double> errors_m;
    for (const auto& [block, mesh] : reader.blocks()) {
      for (const auto& vertex : mesh->vertices) {
        errors_m.push_back(std::abs(computeSceneDistance(room, vertex.cast<double>())));
      }
    }
    std::sort(errors_m.begin(), errors_m.end());
    return errors_m;
  }
  /// Left and right of the middle, the farthest that a primitive's centre is from its box's.
  std::map<bool, double> computeOffsets() const {
    std::map<bool, double> offsets_m;
    for (const auto& message : primitives_->messages()) {
      for (const auto& primitive : message->primitives) {
        const auto& center = primitive.box.pose.position;
        const double offset_m = std::hypot(center.x - 1.5, std::abs(center.y) - 0.8);
        double& farthest_m = offsets_m[center.y > 0.0];
        farthest_m = std::max(farthest_m, offset_m);
      }
    }
    return offsets_m;
  }
  /// Both boxes have a primitive where they are, and the mesh lies on the room's surfaces.
  void expectTheRoom() {
    ASSERT_TRUE(waitUntil([&] { return computeOffsets().size() == 2; }));
    for (const auto& [is_left, offset_m] : computeOffsets()) EXPECT_LT(offset_m, 0.2) << is_left;
    const auto errors_m = computeErrors();
    ASSERT_GT(errors_m.size(), 1000U);
    EXPECT_LT(errors_m[errors_m.size() / 2], 0.01);
    EXPECT_LT(errors_m[errors_m.size() * 9 / 10], 0.05);
  }

  std::map<std::string, std::string> remappings_;
  ros::Publisher info_;
  std::unique_ptr<Recorder<msg::MeshUpdate>> mesh_;
  std::unique_ptr<Recorder<msg::ObjectPrimitives>> primitives_;
};

TEST_F(InputFormsOfTheMap, DistortedImagesAreRectifiedWithTheirLabels) {
  startChain("rectified");
  play([](RobotMessages& messages) { distort(messages, {0.2, 0.0, 0.0, 0.0, 0.0}); });
  expectTheRoom();
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
