// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/camera_intrinsics.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <opencv2/calib3d.hpp>

#include "task_scene_graph/ros/image_conversions.h"

namespace tsg::ros_interface {
namespace {

const cv::Size kSize(64, 48);

sensor_msgs::CameraInfo makeInfo() {
  sensor_msgs::CameraInfo info;
  info.width = 64;
  info.height = 48;
  info.distortion_model = "plumb_bob";
  info.K = {50.0, 0.0, 31.5, 0.0, 51.0, 23.5, 0.0, 0.0, 1.0};
  info.P = {40.0, 0.0, 30.0, 0.0, 0.0, 41.0, 22.0, 0.0, 0.0, 0.0, 1.0, 0.0};
  return info;
}

template <typename Action>
std::string errorOf(Action action) {
  try {
    action();
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

CameraModel cameraOf(const sensor_msgs::CameraInfo& info, Rectification rectification,
                     cv::Size size = kSize) {
  return toIntrinsics(info, size, rectification, "/info").camera;
}

TEST(Intrinsics, RectifiedImagesHaveP) {
  EXPECT_EQ(cameraOf(makeInfo(), Rectification::kDone), (CameraModel{64, 48, 40, 41, 30, 22}));
  sensor_msgs::CameraInfo info = makeInfo();
  info.P.assign(0.0);
  EXPECT_EQ(cameraOf(info, Rectification::kDone), (CameraModel{64, 48, 50, 51, 31.5, 23.5}));
}

TEST(Intrinsics, DistortedImagesThatAreTakenAsTheyAreHaveK) {
  sensor_msgs::CameraInfo info = makeInfo();
  info.D = {0.1, 0.0, 0.0, 0.0, 0.0};
  EXPECT_EQ(cameraOf(info, Rectification::kIgnored), (CameraModel{64, 48, 50, 51, 31.5, 23.5}));
  info.D.assign(5, 0.0);
  EXPECT_EQ(cameraOf(info, Rectification::kIgnored), (CameraModel{64, 48, 40, 41, 30, 22}));
}

TEST(Intrinsics, OnlyDistortedImagesAreRectified) {
  sensor_msgs::CameraInfo info = makeInfo();
  EXPECT_EQ(toIntrinsics(info, kSize, Rectification::kWanted, "/info").rectification, nullptr);
  info.D = {0.1, 0.0, 0.0, 0.0, 0.0};
  const Intrinsics wanted = toIntrinsics(info, kSize, Rectification::kWanted, "/info");
  ASSERT_NE(wanted.rectification, nullptr);
  EXPECT_EQ(wanted.camera, (CameraModel{64, 48, 40, 41, 30, 22}));
  EXPECT_EQ(toIntrinsics(info, kSize, Rectification::kDone, "/info").rectification, nullptr);
}

TEST(Intrinsics, TheMatrixInUseMustBeWholeAlsoWhereTheOtherOneIs) {
  sensor_msgs::CameraInfo info = makeInfo();
  info.P = {40, 0, 30, 0, 0, 41, 22, 0, 0, 0, 1, 0};
  info.K[4] = 0.0;
  EXPECT_NO_THROW(toIntrinsics(info, kSize, Rectification::kDone, "/my/info"));
  info.D = {0.1, 0.0, 0.0, 0.0, 0.0};
  try {
    toIntrinsics(info, kSize, Rectification::kIgnored, "/my/info");
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("/my/info"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("fy"), std::string::npos) << e.what();
  }
}

/// A point seen through the lens lands where the rectified camera sees it.
void expectRectifies(const sensor_msgs::CameraInfo& info, bool is_fisheye) {
  const Intrinsics intrinsics = toIntrinsics(info, kSize, Rectification::kWanted, "/info");
  ASSERT_NE(intrinsics.rectification, nullptr);
  const cv::Point3d point(0.25, -0.2, 1.0);
  const cv::Mat K(3, 3, CV_64F, const_cast<double*>(info.K.data()));
  std::vector<cv::Point2d> raw;
  const std::vector<cv::Point3d> points{point};
  const cv::Vec3d zero(0, 0, 0);
  if (is_fisheye) {
    cv::fisheye::projectPoints(points, raw, zero, zero, K, cv::Mat(info.D, true));
  } else {
    cv::projectPoints(points, zero, zero, K, cv::Mat(info.D, true), raw);
  }
  const Eigen::Vector2d expected = intrinsics.camera.project({point.x, point.y, point.z});
  cv::Mat columns(kSize, CV_32FC1);
  cv::Mat rows(kSize, CV_32FC1);
  for (int v = 0; v < kSize.height; ++v) {
    for (int u = 0; u < kSize.width; ++u) {
      columns.at<float>(v, u) = static_cast<float>(u);
      rows.at<float>(v, u) = static_cast<float>(v);
    }
  }
  const int u = static_cast<int>(std::lround(expected.x()));
  const int v = static_cast<int>(std::lround(expected.y()));
  const double zoom = 1.6;  // raw pixels a rectified pixel spans at most
  EXPECT_NEAR(intrinsics.rectification->applyLinear(columns).at<float>(v, u), raw[0].x, zoom);
  EXPECT_NEAR(intrinsics.rectification->applyLinear(rows).at<float>(v, u), raw[0].y, zoom);
  EXPECT_GT(std::hypot(raw[0].x - expected.x(), raw[0].y - expected.y()), 2.0) << "no distortion";
}

TEST(Intrinsics, RectificationFollowsTheLensModel) {
  sensor_msgs::CameraInfo info = makeInfo();
  info.D = {-0.3, 0.1, 0.001, -0.002, 0.0};
  expectRectifies(info, false);
  info.distortion_model = "rational_polynomial";
  info.D = {-0.3, 0.1, 0.0, 0.0, 0.01, 0.1, 0.0, 0.0};
  expectRectifies(info, false);
  info.distortion_model = "equidistant";
  info.D = {0.1, 0.01, 0.0, 0.0};
  expectRectifies(info, true);
}

TEST(Intrinsics, UnknownLensModelsAreNamed) {
  sensor_msgs::CameraInfo info = makeInfo();
  info.distortion_model = "omnidirectional";
  info.D = {0.1, 0.2};
  const std::string error =
      errorOf([&] { toIntrinsics(info, kSize, Rectification::kWanted, "/my/info"); });
  EXPECT_NE(error.find("/my/info"), std::string::npos) << error;
  EXPECT_NE(error.find("'omnidirectional' with 2 coefficients"), std::string::npos) << error;
}

TEST(Intrinsics, SizeOfAnotherImageIsNamed) {
  const std::string error = errorOf([&] { cameraOf(makeInfo(), Rectification::kDone, {32, 24}); });
  EXPECT_NE(error.find("is for 64x48, the colour images are 32x24"), std::string::npos) << error;
}

TEST(Intrinsics, AMessageWithoutSizeFitsAnyImage) {
  sensor_msgs::CameraInfo info = makeInfo();
  info.width = info.height = 0;
  EXPECT_EQ(cameraOf(info, Rectification::kDone).width_px, 64);
}

TEST(Intrinsics, BinningAndRegionOfInterestAreCounted) {
  sensor_msgs::CameraInfo info = makeInfo();
  info.binning_x = info.binning_y = 2;
  EXPECT_EQ(cameraOf(info, Rectification::kDone, {32, 24}),
            (CameraModel{32, 24, 20, 20.5, 15, 11}));
  info.binning_x = info.binning_y = 0;
  info.roi.x_offset = 10;
  info.roi.y_offset = 4;
  info.roi.width = 40;
  info.roi.height = 30;
  EXPECT_EQ(cameraOf(info, Rectification::kDone, {40, 30}), (CameraModel{40, 30, 40, 41, 20, 18}));
}

TEST(Intrinsics, NumbersThatAreNotFiniteAreNamed) {
  sensor_msgs::CameraInfo info = makeInfo();
  info.K[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(errorOf([&] { checkCameraInfo(info, "/my/info"); }).find("/my/info has K[4] = nan"),
            std::string::npos);
  info = makeInfo();
  info.P.assign(0.0);
  info.K[0] = 0.0;
  EXPECT_NE(errorOf([&] { checkCameraInfo(info, "/my/info"); }).find("/my/info"),
            std::string::npos);
}

TEST(Intrinsics, DistortionThatIsNotFiniteMattersOnlyWhereItIsToBeRemoved) {
  sensor_msgs::CameraInfo info = makeInfo();
  info.D = {std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0, 0.0, 0.0};
  EXPECT_EQ(cameraOf(info, Rectification::kIgnored), (CameraModel{64, 48, 40, 41, 30, 22}));
  EXPECT_NE(errorOf([&] { cameraOf(info, Rectification::kWanted); }).find("D[0] = nan"),
            std::string::npos);
}

TEST(Intrinsics, AnotherSizeKeepsPixelCentresAtWholeNumbers) {
  const CameraModel half = resizeCamera({64, 48, 50.0, 50.0, 31.5, 23.5}, {32, 24});
  EXPECT_EQ(half, (CameraModel{32, 24, 25.0, 25.0, 15.5, 11.5}));
}

TEST(RectifiedTopics, AreToldByTheirNames) {
  for (const char* topic : {"/camera/color/image_rect_color", "/kinect2/hd/image_color_rect",
                            "/zed/rgb/image_rect_color/compressed", "/depth/image_rect_raw"}) {
    EXPECT_TRUE(isRectifiedTopic(topic)) << topic;
  }
  for (const char* topic : {"/camera/color/image_raw", "/rect/image_raw", "/camera/direct_image",
                            "/camera/image_raw/compressed"}) {
    EXPECT_FALSE(isRectifiedTopic(topic)) << topic;
  }
}

class LoadIntrinsics : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
    path_ = std::filesystem::temp_directory_path() / ("tsg_intrinsics_" + name);
  }
  void TearDown() override { std::filesystem::remove(path_); }
  sensor_msgs::CameraInfo load(const std::string& text) {
    std::ofstream(path_) << text;
    return loadIntrinsics(path_.string());
  }
  std::filesystem::path path_;
};

TEST_F(LoadIntrinsics, NumbersStandForThemselves) {
  const auto info = loadIntrinsics("525, 526,319.5 239.5");
  EXPECT_EQ(cameraOf(info, Rectification::kDone, {640, 480}),
            (CameraModel{640, 480, 525, 526, 319.5, 239.5}));
  EXPECT_EQ(loadIntrinsics("525,526,319.5,239.5,640,480").width, 640U);
}

TEST_F(LoadIntrinsics, MatricesOfThreeAndFourRowsAreRead) {
  const CameraModel expected{640, 480, 525, 526, 319.5, 239.5};
  const auto three = load("525 0 319.5\n0 526 239.5\n0 0 1\n");
  EXPECT_EQ(cameraOf(three, Rectification::kDone, {640, 480}), expected);
  const auto four = load("525 0 319.5 0\n0 526 239.5 0\n0 0 1 0\n0 0 0 1\n");
  EXPECT_EQ(cameraOf(four, Rectification::kDone, {640, 480}), expected);
}

TEST_F(LoadIntrinsics, CalibrationsAreReadWithTheirDistortion) {
  const auto info = load(
      "image_width: 64\nimage_height: 48\ncamera_name: head\n"
      "camera_matrix: {rows: 3, cols: 3, data: [50, 0, 31.5, 0, 51, 23.5, 0, 0, 1]}\n"
      "distortion_model: plumb_bob\n"
      "distortion_coefficients: {rows: 1, cols: 5, data: [0.1, 0, 0, 0, 0]}\n"
      "projection_matrix: {rows: 3, cols: 4, data: [40, 0, 30, 0, 0, 41, 22, 0, 0, 0, 1, 0]}\n");
  EXPECT_EQ(cameraOf(info, Rectification::kWanted), (CameraModel{64, 48, 40, 41, 30, 22}));
  EXPECT_TRUE(hasDistortion(info));
}

TEST_F(LoadIntrinsics, FlatKeysAreRead) {
  const auto info = load("fx: 50\nfy: 51\ncx: 31.5\ncy: 23.5\nwidth: 64\nheight: 48\n");
  EXPECT_EQ(cameraOf(info, Rectification::kDone), (CameraModel{64, 48, 50, 51, 31.5, 23.5}));
}

TEST_F(LoadIntrinsics, WhatIsNoneIsNamedWithWhatIsExpected) {
  EXPECT_NE(errorOf([&] { load("model: pinhole\n"); }).find("no camera_matrix"), std::string::npos);
  EXPECT_NE(errorOf([&] { load("1 2 3\n"); }).find("3 numbers"), std::string::npos);
  EXPECT_NE(errorOf([&] { load("camera_matrix: {data: [1, 2]}\n"); }).find("camera_matrix has 2"),
            std::string::npos);
  EXPECT_NE(errorOf([&] { loadIntrinsics("/nonexistent/camera.yaml"); }).find("fx,fy,cx,cy"),
            std::string::npos);
  EXPECT_NE(errorOf([&] { loadIntrinsics("525,525"); }).find("2 numbers"), std::string::npos);
  EXPECT_NE(errorOf([&] { loadIntrinsics("-5,525,1,1"); }).find("fx"), std::string::npos);
}

}  // namespace
}  // namespace tsg::ros_interface
