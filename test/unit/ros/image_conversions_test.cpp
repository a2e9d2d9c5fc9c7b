// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/image_conversions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <boost/weak_ptr.hpp>
#include <limits>

namespace tsg::ros_interface {
namespace {

template <typename Action>
std::string messageOf(Action action) {
  try {
    action();
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

sensor_msgs::ImagePtr makeColor(const std::string& encoding, int type) {
  return toImageMessage(cv::Mat(4, 6, type, cv::Scalar(10, 20, 30, 40)), encoding, {5}, "camera");
}

sensor_msgs::CameraInfo makeInfo() {
  sensor_msgs::CameraInfo info;
  info.width = 6;
  info.height = 4;
  info.K = {5.0, 0.0, 2.5, 0.0, 6.0, 1.5, 0.0, 0.0, 1.0};
  return info;
}

TEST(ColorConversion, SharesThePixelsOfRgbAndBgr) {
  for (const std::string encoding : {"rgb8", "bgr8"}) {
    const sensor_msgs::ImageConstPtr message = makeColor(encoding, CV_8UC3);
    const ColorImage color = toColorImage(message, "/color");
    EXPECT_EQ(color.image.data, message->data.data());
    EXPECT_TRUE(isShared(color.image, *message));
    EXPECT_EQ(color.order, encoding == "bgr8" ? ColorOrder::kBgr : ColorOrder::kRgb);
    EXPECT_EQ(color.stamp.ns, 5);
  }
}

TEST(ColorConversion, TheViewKeepsTheMessageAlive) {
  sensor_msgs::ImageConstPtr message = makeColor("rgb8", CV_8UC3);
  const boost::weak_ptr<const sensor_msgs::Image> watch = message;
  {
    const ColorImage color = toColorImage(message, "/color");
    message.reset();
    ASSERT_FALSE(watch.expired());
    EXPECT_EQ(color.image.at<cv::Vec3b>(3, 5), cv::Vec3b(10, 20, 30));
  }
  EXPECT_TRUE(watch.expired());
}

TEST(ColorConversion, OtherEncodingsAreConvertedWithOneCopy) {
  const sensor_msgs::ImageConstPtr bgra = makeColor("bgra8", CV_8UC4);
  const ColorImage color = toColorImage(bgra, "/color");
  EXPECT_FALSE(isShared(color.image, *bgra));
  EXPECT_EQ(color.order, ColorOrder::kRgb);
  EXPECT_EQ(color.image.at<cv::Vec3b>(0, 0), cv::Vec3b(30, 20, 10));
  const ColorImage gray = toColorImage(makeColor("mono8", CV_8UC1), "/color");
  EXPECT_EQ(gray.image.at<cv::Vec3b>(2, 2), cv::Vec3b(10, 10, 10));
}

TEST(ColorConversion, UnknownEncodingIsNamedWithTheTopic) {
  for (const auto& [encoding, type] :
       {std::pair<std::string, int>{"16UC1", CV_16UC1}, {"bayer_rggb8", CV_8UC1}}) {
    const auto message = makeColor(encoding, type);
    const std::string error = messageOf([&] { toColorImage(message, "/my/color"); });
    EXPECT_NE(error.find("/my/color has encoding '" + encoding + "', expected rgb8 or bgr8"),
              std::string::npos)
        << error;
  }
}

TEST(ColorConversion, TooFewBytesAreAnError) {
  const auto message = makeColor("rgb8", CV_8UC3);
  message->data.resize(10);
  const std::string error = messageOf([&] { toColorImage(message, "/my/color"); });
  EXPECT_NE(error.find("/my/color (6x4, step 18, 10 bytes"), std::string::npos) << error;
}

TEST(ColorConversion, ImagesWithoutPixelsAreAnError) {
  const auto message = makeColor("rgb8", CV_8UC3);
  message->height = 0;
  const std::string error = messageOf([&] { toColorImage(message, "/my/color"); });
  EXPECT_NE(error.find("/my/color is 6x0"), std::string::npos) << error;
}

TEST(DepthConversion, MillimetresAndMetresGiveTheSameDepth) {
  const auto millimetres =
      toImageMessage(cv::Mat(4, 6, CV_16UC1, cv::Scalar(1500)), "16UC1", {5}, "camera");
  const auto metres = toImageMessage(cv::Mat(4, 6, CV_32FC1, cv::Scalar(1.5)), "32FC1", {5}, "c");
  EXPECT_FLOAT_EQ(toDepthImage(millimetres, "/depth").at(2, 3), 1.5F);
  EXPECT_FLOAT_EQ(toDepthImage(metres, "/depth").at(2, 3), 1.5F);
  EXPECT_TRUE(isShared(toDepthImage(millimetres, "/depth").image, *millimetres));
  EXPECT_TRUE(isShared(toDepthImage(metres, "/depth").image, *metres));
  millimetres->encoding = "mono16";
  EXPECT_FLOAT_EQ(toDepthImage(millimetres, "/depth").at(0, 0), 1.5F);
}

TEST(DepthConversion, BigEndianImagesComeRight) {
  auto millimetres = toImageMessage(cv::Mat(4, 6, CV_16UC1, cv::Scalar(0x0102)), "16UC1", {5}, "");
  millimetres->is_bigendian = 1;
  EXPECT_FLOAT_EQ(toDepthImage(millimetres, "/depth").at(5, 3), 0.513F);  // 0x0201 mm
  auto metres = toImageMessage(cv::Mat(4, 6, CV_32FC1), "32FC1", {5}, "");
  metres->is_bigendian = 1;
  for (std::size_t i = 0; i < metres->data.size(); i += 4) {
    const std::uint8_t two_and_a_half[] = {0x40, 0x20, 0x00, 0x00};
    std::copy_n(two_and_a_half, 4, &metres->data[i]);
  }
  EXPECT_EQ(toDepthImage(metres, "/depth").at(5, 3), 2.5F);
}

TEST(DepthConversion, WrongEncodingIsNamedWithTheTopic) {
  const auto message = makeColor("rgb8", CV_8UC3);
  const std::string error = messageOf([&] { toDepthImage(message, "/my/depth"); });
  EXPECT_NE(error.find("/my/depth has encoding 'rgb8', expected 16UC1"), std::string::npos)
      << error;
}

TEST(CameraConversion, DistortionIsSeen) {
  sensor_msgs::CameraInfo info = makeInfo();
  EXPECT_FALSE(hasDistortion(info));
  info.D = {0.0, 0.0, 0.0, 0.0, 0.0};
  EXPECT_FALSE(hasDistortion(info));
  info.D[1] = -0.2;
  EXPECT_TRUE(hasDistortion(info));
}

}  // namespace
}  // namespace tsg::ros_interface
