// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/frame_assembler.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <map>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/image_conversions.h"

namespace tsg::ros_interface {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;

SourceImage makeColor(double seconds, cv::Size size = {kWidth, kHeight}) {
  return SourceImage(sensor_msgs::ImageConstPtr(
      toImageMessage(cv::Mat(size, CV_8UC3, cv::Scalar(10, 20, 30)), "rgb8",
                     Stamp::fromSeconds(seconds), "color_frame")));
}

SourceImage makeDepth(double seconds, cv::Size size = {kWidth, kHeight}) {
  return SourceImage(
      sensor_msgs::ImageConstPtr(toImageMessage(cv::Mat(size, CV_16UC1, cv::Scalar(2000)), "16UC1",
                                                Stamp::fromSeconds(seconds), "depth_frame")));
}

sensor_msgs::CameraInfoPtr makeInfo() {
  auto info = boost::make_shared<sensor_msgs::CameraInfo>();
  info->width = kWidth;
  info->height = kHeight;
  info->K = {50.0, 0.0, 31.5, 0.0, 50.0, 23.5, 0.0, 0.0, 1.0};
  return info;
}

class FrameAssemblerTest : public ::testing::Test {
 protected:
  FrameAssembler& make(const InputConfig& config = {}) {
    FrameAssembler::Callbacks callbacks;
    callbacks.on_frame = [this](AssembledFrame frame) { frames_.push_back(std::move(frame)); };
    callbacks.on_drop = [this](const std::string& reason, const std::string& text,
                               std::uint64_t count) {
      drops_[reason] += count;
      texts_ += text + "\n";
    };
    callbacks.on_warning = [this](const std::string& key, const std::string& text) {
      warnings_[key] = text;
    };
    callbacks.on_jump_back = [this] { ++num_jumps_; };
    callbacks.on_image = [this](bool is_shared, const void*) { num_shared_ += is_shared ? 1 : 0; };
    assembler_ = std::make_unique<FrameAssembler>(
        config, InputTopics{"/color/image_raw", "/depth/image", "/color/camera_info"},
        std::move(callbacks));
    return *assembler_;
  }
  void addPair(double seconds) {
    assembler_->addColor(makeColor(seconds));
    assembler_->addDepth(makeDepth(seconds));
  }

  std::unique_ptr<FrameAssembler> assembler_;
  std::vector<AssembledFrame> frames_;
  std::map<std::string, std::uint64_t> drops_;
  std::map<std::string, std::string> warnings_;
  std::string texts_;
  int num_jumps_ = 0;
  int num_shared_ = 0;
};

TEST_F(FrameAssemblerTest, CameraInfoIsHeld) {
  make().addCameraInfo(makeInfo());
  for (int i = 0; i < 20; ++i) addPair(1.0 + i);
  EXPECT_EQ(frames_.size(), 20U);
  EXPECT_EQ(num_shared_, 40);
  EXPECT_TRUE(drops_.empty());
  EXPECT_EQ(frames_[3].camera_frame, "color_frame");
  EXPECT_EQ(frames_[3].frame->camera, (CameraModel{kWidth, kHeight, 50, 50, 31.5, 23.5}));
}

TEST_F(FrameAssemblerTest, ImagesBeforeTheFirstCameraInfoWaitForIt) {
  make();
  for (int i = 0; i < 5; ++i) addPair(1.0 + i);
  EXPECT_TRUE(frames_.empty());
  EXPECT_EQ(assembler_->numWaiting(), 5U);
  assembler_->addCameraInfo(makeInfo());
  ASSERT_EQ(frames_.size(), 5U);
  EXPECT_EQ(frames_[0].frame->stamp, Stamp::fromSeconds(1.0));
}

TEST_F(FrameAssemblerTest, WithoutCameraInfoFramesAreDroppedAndTheRemedyIsNamed) {
  InputConfig config;
  config.queue_size = 3;
  make(config);
  for (int i = 0; i < 5; ++i) addPair(1.0 + i);
  EXPECT_EQ(drops_["no camera_info"], 2U);
  assembler_->flush();
  EXPECT_EQ(drops_["no camera_info"], 5U);
  EXPECT_NE(texts_.find("/color/camera_info"), std::string::npos);
  EXPECT_NE(texts_.find("--intrinsics"), std::string::npos);
}

TEST_F(FrameAssemblerTest, BadCameraInfoLeavesTheOneBeforeInForce) {
  make().addCameraInfo(makeInfo());
  auto bad = makeInfo();
  bad->K[0] = std::nan("");
  assembler_->addCameraInfo(bad);
  addPair(1.0);
  EXPECT_EQ(frames_.size(), 1U);
  EXPECT_EQ(drops_["bad intrinsics"], 1U);
  EXPECT_NE(texts_.find("K[0] = nan"), std::string::npos);
  EXPECT_NE(texts_.find("stays in force"), std::string::npos);
}

TEST_F(FrameAssemblerTest, IntrinsicsOfTheConfigurationNeedNoCameraInfo) {
  InputConfig config;
  config.intrinsics.text = "40,41,30,20";
  make(config);
  addPair(1.0);
  auto other = makeInfo();
  assembler_->addCameraInfo(other);
  addPair(2.0);
  ASSERT_EQ(frames_.size(), 2U);
  EXPECT_EQ(frames_[1].frame->camera, (CameraModel{kWidth, kHeight, 40, 41, 30, 20}));
}

TEST_F(FrameAssemblerTest, StampsThatAreZeroRepeatedOrLateAreDropped) {
  make().addCameraInfo(makeInfo());
  assembler_->addColor(makeColor(0.0));
  assembler_->addDepth(makeDepth(0.0));
  addPair(5.0);
  assembler_->addColor(makeColor(5.0));
  assembler_->addColor(makeColor(4.5));
  EXPECT_EQ(frames_.size(), 1U);
  EXPECT_EQ(drops_["stamp is 0"], 2U);
  EXPECT_EQ(drops_["repeated stamp"], 1U);
  EXPECT_EQ(drops_["late"], 1U);
}

TEST_F(FrameAssemblerTest, UnmatchedImagesAreCountedWithTheNearestDistance) {
  make().addCameraInfo(makeInfo());
  for (int i = 0; i < 10; ++i) {
    assembler_->addColor(makeColor(1.0 + 0.1 * i));
    assembler_->addDepth(makeDepth(1.033 + 0.1 * i));
  }
  assembler_->flush();
  EXPECT_EQ(drops_["no depth image"], 10U);
  EXPECT_NE(texts_.find("0.033 s away: raise input/sync_tolerance_s"), std::string::npos) << texts_;
  EXPECT_EQ(assembler_->counters().unmatched_colors, 10U);
  EXPECT_EQ(assembler_->counters().unmatched_depths, 10U);
  EXPECT_NEAR(assembler_->counters().nearest_unmatched_s.value_or(0.0), 0.033, 1e-6);
}

TEST_F(FrameAssemblerTest, TimeThatJumpsBackStartsAnew) {
  make().addCameraInfo(makeInfo());
  addPair(50.0);
  addPair(51.0);
  assembler_->addColor(makeColor(52.0));
  addPair(10.0);
  EXPECT_EQ(num_jumps_, 1);
  EXPECT_EQ(drops_["time jumped back"], 1U);
  EXPECT_EQ(frames_.back().frame->stamp, Stamp::fromSeconds(10.0));
}

TEST_F(FrameAssemblerTest, DistortionIsWarnedOfOnceAndNotOnRectifiedTopics) {
  auto info = makeInfo();
  info->D = {0.1, 0.0, 0.0, 0.0, 0.0};
  make().addCameraInfo(info);
  EXPECT_NE(warnings_["distortion"].find("--rectify"), std::string::npos);
  warnings_.clear();
  InputConfig config;
  config.rectify = true;
  make(config).addCameraInfo(info);
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(FrameAssemblerTest, RectifyingTakesLabelsAlong) {
  InputConfig config;
  config.rectify = true;
  auto info = makeInfo();
  info->D = {-0.3, 0.1, 0.0, 0.0, 0.0};
  make(config).addCameraInfo(info);
  addPair(1.0);
  ASSERT_EQ(frames_.size(), 1U);
  ASSERT_NE(frames_[0].frame->color_warp, nullptr);
  EXPECT_EQ(frames_[0].frame->published_color.image.size(), cv::Size(kWidth, kHeight));
  EXPECT_FLOAT_EQ(frames_[0].frame->depth.at(kWidth / 2, kHeight / 2), 2.0F);
}

TEST_F(FrameAssemblerTest, DepthScaleIsMetresForAUnitOrUnitsForAMetre) {
  for (const double scale : {0.00025, 4000.0}) {
    InputConfig config;
    config.depth_scale = scale;
    frames_.clear();
    make(config).addCameraInfo(makeInfo());
    addPair(1.0);
    ASSERT_EQ(frames_.size(), 1U);
    EXPECT_FLOAT_EQ(frames_[0].frame->depth.at(5, 5), 0.5F);
  }
}

TEST_F(FrameAssemblerTest, SizesThatDifferAreRefusedWithTheRemedy) {
  make().addCameraInfo(makeInfo());
  assembler_->addColor(makeColor(1.0));
  assembler_->addDepth(makeDepth(1.0, {kWidth / 2, kHeight / 2}));
  EXPECT_EQ(drops_["sizes differ"], 1U);
  EXPECT_NE(texts_.find("is 32x24, colour on /color/image_raw is 64x48"), std::string::npos);
  EXPECT_NE(texts_.find("--match-size"), std::string::npos);
}

TEST_F(FrameAssemblerTest, ColourIsBroughtToTheSizeOfDepth) {
  InputConfig config;
  config.match_size = MatchSize::kColorToDepth;
  make(config).addCameraInfo(makeInfo());
  assembler_->addColor(makeColor(1.0));
  assembler_->addDepth(makeDepth(1.0, {kWidth / 2, kHeight / 2}));
  ASSERT_EQ(frames_.size(), 1U) << texts_;
  const RgbdFrame& frame = *frames_[0].frame;
  EXPECT_EQ(frame.camera, (CameraModel{32, 24, 25, 25, 15.5, 11.5}));
  EXPECT_NO_THROW(frame.validate());
  EXPECT_EQ(frame.color.image.at<cv::Vec3b>(5, 5), cv::Vec3b(10, 20, 30));
  EXPECT_EQ(frame.color_warp->sourceSize(), cv::Size(kWidth, kHeight));
}

TEST_F(FrameAssemblerTest, DepthIsBroughtToTheSizeOfColour) {
  InputConfig config;
  config.match_size = MatchSize::kDepthToColor;
  make(config).addCameraInfo(makeInfo());
  assembler_->addColor(makeColor(1.0));
  assembler_->addDepth(makeDepth(1.0, {kWidth / 4, kHeight / 4}));
  ASSERT_EQ(frames_.size(), 1U) << texts_;
  EXPECT_NO_THROW(frames_[0].frame->validate());
  EXPECT_EQ(frames_[0].frame->color_warp, nullptr);
  EXPECT_FLOAT_EQ(frames_[0].frame->depth.at(3, 40), 2.0F);
}

TEST_F(FrameAssemblerTest, DepthOfAnotherPartOfTheWorldIsRefused) {
  InputConfig config;
  config.match_size = MatchSize::kColorToDepth;
  make(config).addCameraInfo(makeInfo());
  assembler_->addColor(makeColor(1.0));
  assembler_->addDepth(makeDepth(1.0, {kWidth / 2, kHeight / 4}));
  EXPECT_EQ(drops_["sizes differ"], 1U);
  EXPECT_NE(texts_.find("different ratios"), std::string::npos);
}

TEST_F(FrameAssemblerTest, RectifyingAndResizingGoTogether) {
  InputConfig config;
  config.rectify = true;
  auto info = makeInfo();
  info->D = {-0.2, 0.05, 0.0, 0.0, 0.0};
  for (const MatchSize match_size : {MatchSize::kColorToDepth, MatchSize::kDepthToColor}) {
    config.match_size = match_size;
    frames_.clear();
    make(config).addCameraInfo(info);
    assembler_->addColor(makeColor(1.0));
    assembler_->addDepth(makeDepth(1.0, {kWidth / 2, kHeight / 2}));
    ASSERT_EQ(frames_.size(), 1U) << texts_;
    const RgbdFrame& frame = *frames_[0].frame;
    EXPECT_NO_THROW(frame.validate());
    EXPECT_EQ(frame.color_warp->size(), frame.color.image.size());
    EXPECT_FLOAT_EQ(frame.depth.at(frame.camera.width_px / 2, frame.camera.height_px / 2), 2.0F);
  }
}

TEST_F(FrameAssemblerTest, ContradictingSettingsAreRefused) {
  InputConfig config;
  config.pose_topic = "/odom";
  config.trajectory = "poses.txt";
  EXPECT_THROW(make(config), config::ConfigError);
  config = {};
  config.depth_scale = 1e-7;
  EXPECT_THROW(make(config), config::ConfigError);
  config = {};
  config.color_topic = "";
  EXPECT_THROW(make(config), config::ConfigError);
}

}  // namespace
}  // namespace tsg::ros_interface
