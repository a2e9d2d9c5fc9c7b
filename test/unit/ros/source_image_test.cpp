// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/source_image.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cmath>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "ros/rvl.h"
#include "task_scene_graph/ros/image_conversions.h"

namespace tsg::ros_interface {
namespace {

SourceImage makeCompressed(const std::string& format, std::vector<std::uint8_t> data) {
  auto message = boost::make_shared<sensor_msgs::CompressedImage>();
  message->header.stamp.fromSec(7.0);
  message->header.frame_id = "camera";
  message->format = format;
  message->data = std::move(data);
  return SourceImage(sensor_msgs::CompressedImageConstPtr(message));
}

std::vector<std::uint8_t> encode(const std::string& ending, const cv::Mat& image) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(ending, image, bytes);
  return bytes;
}

std::vector<std::uint8_t> withDepthHeader(float a, float b, const std::vector<std::uint8_t>& data) {
  std::vector<std::uint8_t> bytes(12 + data.size());
  std::memcpy(bytes.data() + 4, &a, 4);
  std::memcpy(bytes.data() + 8, &b, 4);
  std::copy(data.begin(), data.end(), bytes.begin() + 12);
  return bytes;
}

cv::Mat makeDepth() {
  cv::Mat depth(20, 30, CV_16UC1);
  cv::randu(depth, 300, 5000);
  depth.colRange(3, 9).setTo(0);
  return depth;
}

/// The reference of the paper, written from its text: what decodeRvl reads.
std::vector<std::uint8_t> encodeRvl(const cv::Mat& depth) {
  std::vector<std::uint32_t> nibbles;
  const auto put = [&](std::uint32_t value) {
    do {
      std::uint32_t nibble = value & 7U;
      value >>= 3U;
      if (value != 0) nibble |= 8U;
      nibbles.push_back(nibble);
    } while (value != 0);
  };
  const auto* pixels = depth.ptr<std::uint16_t>();
  const int count = depth.cols * depth.rows;
  int previous = 0;
  for (int i = 0; i < count;) {
    int zeros = 0;
    while (i + zeros < count && pixels[i + zeros] == 0) ++zeros;
    int values = 0;
    while (i + zeros + values < count && pixels[i + zeros + values] != 0) ++values;
    put(static_cast<std::uint32_t>(zeros));
    put(static_cast<std::uint32_t>(values));
    for (int k = i + zeros; k < i + zeros + values; ++k) {
      const int delta = pixels[k] - previous;
      put(static_cast<std::uint32_t>((2 * delta) ^ (delta >> 31)));
      previous = pixels[k];
    }
    i += zeros + values;
  }
  while (nibbles.size() % 8 != 0) nibbles.push_back(0);
  std::vector<std::uint32_t> words{static_cast<std::uint32_t>(depth.cols),
                                   static_cast<std::uint32_t>(depth.rows)};
  for (std::size_t i = 0; i < nibbles.size(); i += 8) {
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 8; ++k) word = (word << 4U) | nibbles[i + k];
    words.push_back(word);
  }
  std::vector<std::uint8_t> bytes(words.size() * 4);
  std::memcpy(bytes.data(), words.data(), bytes.size());
  return bytes;
}

std::string errorOf(const SourceImage& image, const std::string& topic) {
  try {
    image.decode(topic);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(SourceImage, RawImagesArePassedOnUntouched) {
  const sensor_msgs::ImageConstPtr raw = boost::make_shared<sensor_msgs::Image>();
  EXPECT_EQ(SourceImage(raw).decode("/color"), raw);
  EXPECT_FALSE(SourceImage(raw).isCompressed());
}

TEST(SourceImage, JpegAndPngColourIsDecoded) {
  const cv::Mat image(20, 30, CV_8UC3, cv::Scalar(10, 20, 200));
  const auto png = makeCompressed("rgb8; png compressed bgr8", encode(".png", image));
  const auto message = png.decode("/color/compressed");
  const ColorImage color = toColorImage(message, "/color/compressed");
  EXPECT_EQ(cv::norm(color.image, image, cv::NORM_INF), 0.0);
  EXPECT_EQ(color.order, ColorOrder::kBgr);
  EXPECT_EQ(message->header.frame_id, "camera");
  const auto jpeg = makeCompressed("jpeg", encode(".jpg", image));
  EXPECT_LE(cv::norm(toColorImage(jpeg.decode("/c"), "/c").image, image, cv::NORM_INF), 4.0);
}

TEST(SourceImage, DepthPngAndRvlKeepEveryMillimetre) {
  const cv::Mat depth = makeDepth();
  for (const auto& [format, data] :
       {std::pair<std::string, std::vector<std::uint8_t>>{
            "16UC1; compressedDepth", withDepthHeader(0, 0, encode(".png", depth))},
        {"16UC1; compressedDepth png", withDepthHeader(0, 0, encode(".png", depth))},
        {"16UC1; compressedDepth rvl", withDepthHeader(0, 0, encodeRvl(depth))},
        {"16UC1; png compressed", encode(".png", depth)}}) {
    const auto message = makeCompressed(format, data).decode("/depth");
    const DepthImage decoded = toDepthImage(message, "/depth");
    EXPECT_EQ(cv::norm(decoded.image, depth, cv::NORM_INF), 0.0) << format;
    EXPECT_EQ(decoded.metres_per_unit, 0.001);
  }
}

TEST(SourceImage, QuantisedInverseDepthComesBackInMetres) {
  const float a = 1000.0F;
  const float b = -10.0F;
  cv::Mat quantised(4, 5, CV_16UC1, cv::Scalar(a / 2.0 + b));
  quantised.at<std::uint16_t>(1, 1) = 0;
  const auto message =
      makeCompressed("32FC1; compressedDepth png", withDepthHeader(a, b, encode(".png", quantised)))
          .decode("/depth");
  const DepthImage depth = toDepthImage(message, "/depth");
  EXPECT_NEAR(depth.at(0, 0), 2.0F, 0.01F);
  EXPECT_EQ(depth.at(1, 1), 0.0F);
}

TEST(SourceImage, BrokenDataAreNamedWithTopicAndFormat) {
  auto cut = encode(".png", makeDepth());
  cut.resize(cut.size() / 3);
  for (const auto& image :
       {makeCompressed("jpeg", {1, 2, 3}), makeCompressed("jpeg", {}),
        makeCompressed("16UC1; compressedDepth png", withDepthHeader(0, 0, {})),
        makeCompressed("16UC1; compressedDepth png", {1, 2}),
        makeCompressed("16UC1; compressedDepth rvl", withDepthHeader(0, 0, {1, 0, 0, 0, 9}))}) {
    const std::string error = errorOf(image, "/my/topic");
    EXPECT_NE(error.find("/my/topic"), std::string::npos) << error;
    EXPECT_NE(error.find("format '"), std::string::npos) << error;
  }
}

TEST(SourceImage, MutatedRvlNeverReadsBeyondItsData) {
  const auto good = encodeRvl(makeDepth());
  std::mt19937 random(5);
  for (int i = 0; i < 3000; ++i) {
    auto bad = good;
    for (int k = 0; k < 4; ++k) bad[random() % bad.size()] = static_cast<std::uint8_t>(random());
    bad.resize(random() % (bad.size() + 1));
    const cv::Mat depth = decodeRvl(bad.data(), bad.size());
    EXPECT_TRUE(depth.empty() || depth.type() == CV_16UC1);
  }
}

TEST(CompressedTopics, AreToldByTheirNames) {
  EXPECT_TRUE(isCompressedTopic("/camera/color/image_raw/compressed"));
  EXPECT_TRUE(isCompressedTopic("/depth/compressedDepth"));
  EXPECT_FALSE(isCompressedTopic("/camera/color/image_raw"));
  EXPECT_FALSE(isCompressedTopic("/compressed_camera/image"));
}

TEST(Stamps, ZeroAndTheEndOfTimeAreRefused) {
  const auto reasonOf = [](const ros::Time& stamp) -> std::string {
    try {
      checkStamp(stamp, "/camera/color");
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find("/camera/color"), std::string::npos);
      return e.reason();
    }
    return "";
  };
  EXPECT_EQ(reasonOf(ros::Time()), "stamp is 0");
  EXPECT_EQ(reasonOf(ros::Time(4294967295U, 0)), "stamp out of range");
  EXPECT_EQ(reasonOf(ros::Time(0, 1)), "");
  EXPECT_EQ(reasonOf(ros::Time(1700000000U, 0)), "");
}

}  // namespace
}  // namespace tsg::ros_interface
