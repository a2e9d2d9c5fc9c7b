// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/image_motion.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "segmentation/segment_carrier.h"

namespace tsg::segmentation {
namespace {

/// Noise with structure of all sizes, as photographs have it, larger than any view of it.
cv::Mat makeWorld() {
  cv::Mat world(800, 1000, CV_32FC3, cv::Scalar::all(0.0));
  cv::RNG random(5);
  for (const int cell_px : {200, 100, 50, 25, 12}) {
    cv::Mat coarse(800 / cell_px, 1000 / cell_px, CV_32FC3);
    random.fill(coarse, cv::RNG::UNIFORM, -1.0, 1.0);
    cv::Mat layer;
    cv::resize(coarse, layer, world.size(), 0, 0, cv::INTER_CUBIC);
    world += layer * std::sqrt(static_cast<double>(cell_px));
  }
  cv::Mat pixels;
  world.convertTo(pixels, CV_8UC3, 5.0, 128.0);
  return pixels;
}

ColorImage view(const cv::Mat& world, cv::Point corner, double stamp_s = 0.0,
                cv::Size size = {640, 480}) {
  return {Stamp::fromSeconds(stamp_s), world(cv::Rect(corner, size)).clone(), ColorOrder::kRgb,
          nullptr};
}

cv::Mat makeLabels(const cv::Rect& box) {
  cv::Mat labels = cv::Mat::zeros(480, 640, CV_16UC1);
  labels(box & cv::Rect(0, 0, 640, 480)) = 1;
  return labels;
}

double computeIou(const cv::Mat& a, const cv::Mat& b) {
  return static_cast<double>(cv::countNonZero((a == 1) & (b == 1))) /
         cv::countNonZero((a == 1) | (b == 1));
}

TEST(ImageMotion, MovesLabelsWithTheImage) {
  const cv::Mat world = makeWorld();
  const cv::Rect box(200, 150, 120, 90);
  for (const cv::Point shift :
       {cv::Point(0, 0), cv::Point(20, 0), cv::Point(-35, 12), cv::Point(8, -60)}) {
    MotionEstimator estimator;
    estimator.update(view(world, {150, 150}));
    const ImageMotion motion = estimator.update(view(world, cv::Point(150, 150) + shift));
    ASSERT_FALSE(motion.isEmpty());
    EXPECT_GT(computeIou(moveLabels(makeLabels(box), motion), makeLabels(box - shift)), 0.9)
        << shift;
  }
}

TEST(ImageMotion, KnowsHowMuchWasInViewBefore) {
  const cv::Mat world = makeWorld();
  MotionEstimator estimator;
  estimator.update(view(world, {100, 100}));
  EXPECT_GT(estimator.update(view(world, {100, 100})).computeKnownShare(), 0.99);
  const double share = estimator.update(view(world, {164, 100})).computeKnownShare();
  EXPECT_NEAR(share, 0.9, 0.06);  // a tenth of 640 px came in
  cv::Mat other;
  cv::flip(world, other, -1);
  EXPECT_LT(estimator.update(view(other, {100, 100})).computeKnownShare(), 0.8);
}

TEST(ImageMotion, DoesNotDependOnTheNumberOfThreads) {
  const cv::Mat world = makeWorld();
  const int threads_before = cv::getNumThreads();
  std::vector<cv::Mat> origins;
  for (const int threads : {1, 2, 5}) {
    cv::setNumThreads(threads);
    MotionEstimator estimator;
    estimator.update(view(world, {100, 100}));
    origins.push_back(estimator.update(view(world, {137, 81})).origins_px);
  }
  cv::setNumThreads(threads_before);
  EXPECT_EQ(cv::norm(origins[0], origins[1], cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::norm(origins[0], origins[2], cv::NORM_INF), 0.0);
}

TEST(ImageMotion, IsEmptyForTheFirstImageAndAfterAnotherSize) {
  const cv::Mat world = makeWorld();
  MotionEstimator estimator;
  EXPECT_TRUE(estimator.update(view(world, {0, 0})).isEmpty());
  EXPECT_TRUE(estimator.update(view(world, {0, 0}, 0.0, {320, 240})).isEmpty());
  EXPECT_FALSE(estimator.update(view(world, {0, 0}, 0.0, {320, 240})).isEmpty());
  EXPECT_EQ(ImageMotion().computeKnownShare(), 0.0);
}

TEST(ImageMotion, ImagesOfAnySizeWork) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(2, 900), cv::Size(7680, 4320)}) {
    const ColorImage color{
        {}, cv::Mat(size, CV_8UC3, cv::Scalar(10, 90, 20)), ColorOrder::kRgb, nullptr};
    MotionEstimator estimator;
    estimator.update(color);
    const ImageMotion motion = estimator.update(color);
    const cv::Mat labels(size, CV_16UC1, cv::Scalar(1));
    EXPECT_EQ(cv::countNonZero(moveLabels(labels, motion) != 1), 0) << size;
  }
}

TEST(CountCommonPixels, CountsPairsOfLabels) {
  const Eigen::MatrixXi counts =
      countCommonPixels(makeLabels({10, 10, 40, 40}), 1, makeLabels({30, 10, 40, 40}), 1);
  EXPECT_EQ(counts(1, 1), 20 * 40);
  EXPECT_EQ(counts(1, 0), 20 * 40);
  EXPECT_EQ(counts.sum(), 640 * 480);
}

ScheduleConfig skipping(int images) {
  ScheduleConfig config;
  config.max_skipped_images = images;
  return config;
}

/// Shows views that start at these columns, 0.1 s apart; true where the network may be skipped.
std::vector<bool> walk(const ScheduleConfig& config, const std::vector<int>& columns,
                       double period_s = 0.1) {
  const cv::Mat world = makeWorld();
  MotionEstimator estimator;
  SegmentCarrier carrier(config, 20);
  std::vector<bool> carried;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const Stamp stamp = Stamp::fromSeconds(10.0 + period_s * static_cast<double>(i));
    const auto found = carrier.carry(stamp, estimator.update(view(world, {columns[i], 100})));
    carried.push_back(found.has_value());
    const cv::Mat labels = makeLabels({300 - columns[i], 100, 80, 80});
    if (found) {
      EXPECT_GT(computeIou(found->labels, labels), 0.8) << i;
    }
    carrier.setSegments(stamp, found ? *found : collectSegments(labels, {0.7F}, 20),
                        found.has_value());
  }
  return carried;
}

using Carried = std::vector<bool>;

TEST(SegmentCarrier, SkipsAtMostSoManyImagesInARow) {
  EXPECT_EQ(walk(skipping(2), {0, 0, 0, 0, 0, 0, 0}),
            (Carried{false, true, true, false, true, true, false}));
  EXPECT_EQ(walk(skipping(0), {0, 0, 0}), (Carried{false, false, false}));
}

TEST(SegmentCarrier, SkipsNoneOfWhichTooMuchIsNewSinceTheNetworkRan) {
  ScheduleConfig config = skipping(100);
  config.min_known_share = 0.8;
  // 40 of 640 px come in each time: 0.94, 0.88, 0.82, less.
  const Carried carried = walk(config, {0, 40, 80, 120, 160, 200, 240});
  EXPECT_FALSE(carried[0]);
  EXPECT_TRUE(carried[1]);
  EXPECT_TRUE(carried[2]);
  EXPECT_GE(std::count(carried.begin(), carried.end(), false), 2);
}

TEST(SegmentCarrier, SkipsNoneAfterAGapOrAStepBack) {
  EXPECT_EQ(walk(skipping(9), {0, 0}, 1.5), (Carried{false, false}));
  EXPECT_EQ(walk(skipping(9), {0, 0}, -0.1), (Carried{false, false}));
}

}  // namespace
}  // namespace tsg::segmentation
