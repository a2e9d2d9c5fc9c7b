// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/overlay.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace tsg::segmentation {
namespace {

cv::Mat1w makeLabels() {
  cv::Mat1w labels(40, 60, std::uint16_t{0});
  labels(cv::Rect(5, 5, 20, 20)) = 1;
  labels(cv::Rect(25, 5, 20, 20)) = 2;
  labels(cv::Rect(5, 30, 10, 5)) = 65535;
  return labels;
}

TEST(DrawSegments, ColoursSegmentsAndLeavesTheRest) {
  const cv::Mat1w labels = makeLabels();
  const cv::Mat image(40, 60, CV_8UC3, cv::Scalar(40, 80, 120));
  const cv::Mat3b drawn = drawSegments(image, labels, ColorOrder::kRgb);
  EXPECT_EQ(drawn(0, 0), cv::Vec3b(40, 80, 120));
  EXPECT_EQ(drawn(10, 24), cv::Vec3b(255, 255, 255));  // last column of segment 1
  EXPECT_EQ(drawn(10, 10), drawn(20, 20));
  EXPECT_NE(drawn(10, 10), drawn(10, 30));
  EXPECT_NE(drawn(10, 10), cv::Vec3b(40, 80, 120));
  EXPECT_NE(drawn(32, 10), cv::Vec3b(40, 80, 120));
}

TEST(DrawSegments, ShowsTheSameColoursInEitherOrder) {
  cv::Mat rgb(40, 60, CV_8UC3);
  cv::randu(rgb, 0, 256);
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  cv::Mat drawn;
  cv::cvtColor(drawSegments(bgr, makeLabels(), ColorOrder::kBgr), drawn, cv::COLOR_BGR2RGB);
  EXPECT_EQ(cv::norm(drawn, drawSegments(rgb, makeLabels(), ColorOrder::kRgb), cv::NORM_INF), 0.0);
}

TEST(DrawSegments, OtherSizesAndTypesAreRefused) {
  const cv::Mat labels = makeLabels();
  EXPECT_THROW(drawSegments(cv::Mat(40, 61, CV_8UC3), labels, ColorOrder::kRgb),
               std::invalid_argument);
  EXPECT_THROW(drawSegments(cv::Mat(40, 60, CV_8UC1), labels, ColorOrder::kRgb),
               std::invalid_argument);
  EXPECT_THROW(drawSegments(cv::Mat(40, 60, CV_8UC3), cv::Mat(40, 60, CV_8UC1), ColorOrder::kRgb),
               std::invalid_argument);
}

}  // namespace
}  // namespace tsg::segmentation
