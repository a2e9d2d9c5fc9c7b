// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/segment_faults.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/simulation/random.h"

namespace tsg::simulation {
namespace {

constexpr Eigen::Index kSize = 512;

Embedding makeEmbedding(std::uint64_t seed) {
  Random random(seed);
  Embedding embedding(kSize);
  for (Eigen::Index i = 0; i < kSize; ++i) embedding[i] = static_cast<float>(random.normal());
  return embedding.normalized();
}

/// Three squares of 60 px side by side: 1 and 2 touch, 3 stands alone.
Segmentation makeSquares(std::int64_t stamp_ns = 1) {
  Segmentation segmentation;
  segmentation.stamp = Stamp{stamp_ns};
  segmentation.labels = cv::Mat::zeros(240, 320, CV_16UC1);
  segmentation.labels(cv::Rect(20, 40, 60, 60)).setTo(1);
  segmentation.labels(cv::Rect(80, 40, 60, 60)).setTo(2);
  segmentation.labels(cv::Rect(200, 40, 60, 60)).setTo(3);
  segmentation.embeddings.resize(3, kSize);
  for (int i = 0; i < 3; ++i) {
    segmentation.embeddings.row(i) = makeEmbedding(static_cast<std::uint64_t>(i)).transpose();
    segmentation.confidences.push_back(0.9F);
  }
  segmentation.image_embedding = makeEmbedding(9);
  return segmentation;
}

int countPixels(const Segmentation& segmentation, int label) {
  return cv::countNonZero(segmentation.labels == label);
}

bool isSame(const Segmentation& a, const Segmentation& b) {
  return cv::countNonZero(a.labels != b.labels) == 0 && a.embeddings == b.embeddings &&
         a.confidences == b.confidences;
}

TEST(SegmentFaults, NoneByDefault) {
  const Segmentation before = makeSquares();
  EXPECT_TRUE(isSame(SegmentFaults({}).apply(before), before));
}

TEST(SegmentFaults, SameFrameSameFaultsOtherFrameOthers) {
  const SegmentFaults faults(SegmentFaultsConfig::makeHard());
  const Segmentation once = faults.apply(makeSquares());
  EXPECT_TRUE(isSame(once, faults.apply(makeSquares())));
  EXPECT_FALSE(isSame(once, faults.apply(makeSquares(2))));
}

TEST(SegmentFaults, DroppedSegmentsLeaveNoGap) {
  SegmentFaultsConfig config;
  config.dropped = 0.5;
  std::size_t kept = 0;
  for (int i = 0; i < 300; ++i) {
    const Segmentation result = SegmentFaults(config).apply(makeSquares(i));
    EXPECT_NO_THROW(result.validate());
    kept += result.numSegments();
  }
  EXPECT_NEAR(static_cast<double>(kept) / 900.0, 0.5, 0.06);
}

TEST(SegmentFaults, MergedSegmentsTouchedBefore) {
  SegmentFaultsConfig config;
  config.merged = 1.0;
  const Segmentation result = SegmentFaults(config).apply(makeSquares());
  ASSERT_EQ(result.numSegments(), 2U);
  EXPECT_EQ(countPixels(result, 1), 7200);
  EXPECT_EQ(countPixels(result, 2), 3600);
  const Embedding both = result.embeddings.row(0).transpose();
  EXPECT_NEAR(both.dot(makeEmbedding(0)), both.dot(makeEmbedding(1)), 1e-5);
}

TEST(SegmentFaults, SplitSegmentsAreHalvedAcrossTheirLongerSide) {
  SegmentFaultsConfig config;
  config.split = 1.0;
  Segmentation before = makeSquares();
  before.labels = cv::Mat::zeros(240, 320, CV_16UC1);
  before.labels(cv::Rect(20, 40, 120, 20)).setTo(1);
  const Segmentation result = SegmentFaults(config).apply(before);
  ASSERT_EQ(result.numSegments(), 2U);
  EXPECT_EQ(countPixels(result, 1), 1200);
  EXPECT_EQ(countPixels(result, 2), 1200);
  EXPECT_NE(result.labels.at<std::uint16_t>(50, 21), result.labels.at<std::uint16_t>(50, 138));
  EXPECT_EQ(result.embeddings.row(0), result.embeddings.row(1));
}

TEST(SegmentFaults, ErosionTakesTheBorder) {
  SegmentFaultsConfig config;
  config.eroded_px = 2;
  const Segmentation result = SegmentFaults(config).apply(makeSquares());
  EXPECT_EQ(countPixels(result, 3), 56 * 56);
  EXPECT_EQ(result.labels.at<std::uint16_t>(70, 80), 0);  // between 1 and 2
}

TEST(SegmentFaults, PatchesLieWhereNoSegmentWas) {
  SegmentFaultsConfig config;
  config.patches = 5;
  const Segmentation before = makeSquares();
  const Segmentation result = SegmentFaults(config).apply(before);
  EXPECT_GT(result.numSegments(), 3U);
  EXPECT_EQ(cv::countNonZero((before.labels != 0) & (before.labels != result.labels)), 0);
}

TEST(SegmentFaults, TwoViewsHaveTheCosineAsked) {
  SegmentFaultsConfig config;
  config.view_cosine = 0.87;
  const SegmentFaults faults(config);
  double sum = 0.0;
  Embedding mean = Embedding::Zero(kSize);
  Embedding last;
  for (int i = 0; i < 200; ++i) {
    const Embedding view = faults.apply(makeSquares(i)).embeddings.row(0).transpose();
    EXPECT_NEAR(view.norm(), 1.0, 1e-4);
    if (i > 0) sum += view.dot(last);
    last = view;
    mean += view;
  }
  EXPECT_NEAR(sum / 199.0, 0.87, 0.01);
  EXPECT_GT(mean.normalized().dot(makeEmbedding(0)), 0.995);
}

TEST(SegmentFaults, SmallCropsAreNoisier) {
  SegmentFaultsConfig config;
  config.view_cosine = 0.9;
  config.small_crop_px = 3600.0;
  double sum = 0.0;
  for (int i = 0; i < 100; ++i) {
    const Embedding view =
        SegmentFaults(config).apply(makeSquares(i)).embeddings.row(0).transpose();
    sum += view.dot(makeEmbedding(0));
  }
  // s^2 = 2 (1 / 0.9 - 1), and the cosine with the thing itself is 1 / sqrt(1 + s^2).
  EXPECT_NEAR(sum / 100.0, 1.0 / std::sqrt(1.0 + 2.0 / 9.0), 0.01);
}

TEST(SegmentFaults, OutOfRangeIsRefused) {
  SegmentFaultsConfig config;
  config.view_cosine = 1.5;
  EXPECT_THROW(SegmentFaults{config}, config::ConfigError);
}

}  // namespace
}  // namespace tsg::simulation
