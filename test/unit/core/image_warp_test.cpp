// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/image_warp.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "task_scene_graph/core/frame.h"

namespace tsg {
namespace {

cv::Mat makeRamp(int width, int height) {
  cv::Mat image(height, width, CV_16UC1);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u)
      image.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(100 * v + u);
  }
  return image;
}

TEST(ImageWarp, HalvingTakesOneOfTheFourPixelsThatAreCovered) {
  const ImageWarp warp = ImageWarp::resize({8, 6}, {4, 3});
  EXPECT_EQ(warp.sourceSize(), cv::Size(8, 6));
  EXPECT_EQ(warp.size(), cv::Size(4, 3));
  const cv::Mat half = warp.applyNearest(makeRamp(8, 6));
  for (int v = 0; v < 3; ++v) {
    for (int u = 0; u < 4; ++u) {
      const int value = half.at<std::uint16_t>(v, u);
      EXPECT_TRUE(value / 100 == 2 * v || value / 100 == 2 * v + 1) << value;
      EXPECT_TRUE(value % 100 == 2 * u || value % 100 == 2 * u + 1) << value;
    }
  }
}

TEST(ImageWarp, DoublingRepeatsEachPixelFourTimes) {
  const cv::Mat source = makeRamp(4, 3);
  const cv::Mat twice = ImageWarp::resize({4, 3}, {8, 6}).applyNearest(source);
  for (int v = 0; v < 6; ++v) {
    for (int u = 0; u < 8; ++u) {
      EXPECT_EQ(twice.at<std::uint16_t>(v, u), source.at<std::uint16_t>(v / 2, u / 2));
    }
  }
}

TEST(ImageWarp, LinearAgreesWithOpenCvsResize) {
  cv::Mat source(20, 30, CV_8UC3);
  cv::randu(source, 0, 255);
  cv::Mat expected;
  cv::resize(source, expected, {47, 31}, 0.0, 0.0, cv::INTER_LINEAR);
  const cv::Mat actual = ImageWarp::resize({30, 20}, {47, 31}).applyLinear(source);
  // At the border OpenCV repeats pixels, a warp mixes them with what lies outside.
  const cv::Rect inside(1, 1, 45, 29);
  EXPECT_LE(cv::norm(expected(inside), actual(inside), cv::NORM_INF), 8.0);
}

TEST(ImageWarp, OneAfterTheOtherIsTheirComposition) {
  const ImageWarp there = ImageWarp::resize({16, 12}, {32, 24});
  const ImageWarp back = ImageWarp::resize({32, 24}, {16, 12});
  const ImageWarp both = there.followedBy(back);
  EXPECT_EQ(both.sourceSize(), cv::Size(16, 12));
  EXPECT_EQ(both.size(), cv::Size(16, 12));
  const cv::Mat source = makeRamp(16, 12);
  EXPECT_EQ(cv::norm(both.applyNearest(source), source, cv::NORM_INF), 0.0);
}

class AlignToFrame : public ::testing::Test {
 protected:
  static SegmentationPtr makeSegmentation(int width, int height) {
    auto segmentation = std::make_shared<Segmentation>();
    segmentation->labels = cv::Mat(height, width, CV_16UC1, cv::Scalar(1));
    segmentation->labels.colRange(width / 2, width).setTo(2);
    segmentation->embeddings = EmbeddingMatrix::Ones(2, 3);
    segmentation->confidences = {1.0F, 0.5F};
    return segmentation;
  }
};

TEST_F(AlignToFrame, WithoutAWarpTheSegmentationItselfIsReturned) {
  const auto segmentation = makeSegmentation(8, 6);
  EXPECT_EQ(alignToFrame(RgbdFrame(), segmentation), segmentation);
}

TEST_F(AlignToFrame, LabelsFollowTheImage) {
  RgbdFrame frame;
  frame.color_warp = std::make_shared<ImageWarp>(ImageWarp::resize({8, 6}, {4, 3}));
  const auto aligned = alignToFrame(frame, makeSegmentation(8, 6));
  ASSERT_EQ(aligned->labels.size(), cv::Size(4, 3));
  for (int u = 0; u < 4; ++u) EXPECT_EQ(aligned->labels.at<std::uint16_t>(1, u), u < 2 ? 1 : 2);
  EXPECT_EQ(aligned->numSegments(), 2U);
}

TEST_F(AlignToFrame, LabelsOfAnotherSizeAreNamed) {
  RgbdFrame frame;
  frame.color_warp = std::make_shared<ImageWarp>(ImageWarp::resize({8, 6}, {4, 3}));
  try {
    alignToFrame(frame, makeSegmentation(5, 6));
    FAIL() << "no error";
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(
        std::string(e.what()).find("label image is 5x6, expected that of the published colour "
                                   "image, 8x6"),
        std::string::npos)
        << e.what();
  }
}

}  // namespace
}  // namespace tsg
