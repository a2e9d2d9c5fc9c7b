// SPDX-License-Identifier: BSD-3-Clause
// The segmenter with schedule/mode: reuse, on networks with a closed form.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "networks.h"
#include "task_scene_graph/segmentation/segmenter.h"

namespace tsg::segmentation {
namespace {

const cv::Rect kRedBox(8, 12, 24, 20);
const cv::Rect kGreenBox(40, 24, 12, 28);

ColorImage makeImage(double stamp_s, const cv::Scalar& red = {255, 0, 0}) {
  cv::Mat image(64, 64, CV_8UC3, cv::Scalar(100, 100, 100));
  image(kRedBox) = red;
  image(kGreenBox) = cv::Scalar(0, 255, 0);
  return {Stamp::fromSeconds(stamp_s), image, ColorOrder::kRgb, nullptr};
}

SegmenterConfig makeConfig(ScheduleMode mode) {
  SegmenterConfig config;
  config.schedule.mode = mode;
  return config;
}

TEST(SegmenterSchedule, ExactIsTheDefaultAndEmbedsEveryCropOfEveryImage) {
  TSG_REQUIRE_ENGINE();
  Segmenter segmenter(makeSmallModels(), {});
  for (int i = 0; i < 4; ++i) segmenter.segment(makeImage(0.1 * i));
  EXPECT_EQ(segmenter.counters().crops_embedded, 4U * (2 * 2 + 1));
  EXPECT_EQ(segmenter.counters().segments_reused, 0U);
}

TEST(SegmenterSchedule, AStaticSceneCostsItsCropsOnceAndGivesTheSame) {
  TSG_REQUIRE_ENGINE();
  const Segmentation exact = Segmenter(makeSmallModels(), {}).segment(makeImage(0.0));
  Segmenter segmenter(makeSmallModels(), makeConfig(ScheduleMode::kReuse));
  for (int i = 0; i < 4; ++i) {
    const Segmentation result = segmenter.segment(makeImage(0.1 * i));
    result.validate();
    EXPECT_EQ(cv::norm(result.labels, exact.labels, cv::NORM_INF), 0.0);
    EXPECT_EQ(result.confidences, exact.confidences);
    EXPECT_TRUE(result.embeddings.isApprox(exact.embeddings));
    EXPECT_EQ(result.image_embedding.size(), i == 0 ? 4 : 0);
  }
  EXPECT_EQ(segmenter.counters().crops_embedded, 2U * 2 + 1);
  EXPECT_EQ(segmenter.counters().segments_reused, 3U * 2);
}

TEST(SegmenterSchedule, SkippedImagesOfAStaticSceneGiveTheSame) {
  TSG_REQUIRE_ENGINE();
  SegmenterConfig config = makeConfig(ScheduleMode::kReuse);
  config.schedule.max_skipped_images = 3;
  Segmenter segmenter(makeSmallModels(), config);
  const Segmentation first = segmenter.segment(makeImage(0.0));
  for (int i = 1; i < 8; ++i) {
    const Segmentation result = segmenter.segment(makeImage(0.1 * i));
    result.validate();
    EXPECT_EQ(cv::norm(result.labels, first.labels, cv::NORM_INF), 0.0);
    EXPECT_EQ(result.confidences, first.confidences);
    EXPECT_TRUE(result.embeddings.isApprox(first.embeddings));
  }
  EXPECT_EQ(segmenter.counters().images, 8U);
  EXPECT_EQ(segmenter.counters().images_carried, 6U);
}

TEST(SegmenterSchedule, AnImageThatLooksDifferentIsNotSkipped) {
  TSG_REQUIRE_ENGINE();
  SegmenterConfig config = makeConfig(ScheduleMode::kReuse);
  config.schedule.max_skipped_images = 3;
  Segmenter segmenter(makeSmallModels(), config);
  segmenter.segment(makeImage(0.0));
  const ColorImage black{Stamp::fromSeconds(0.1), cv::Mat::zeros(64, 64, CV_8UC3), ColorOrder::kRgb,
                         nullptr};
  EXPECT_EQ(segmenter.segment(black).numSegments(), 0U);
  EXPECT_EQ(segmenter.counters().images_carried, 0U);
}

TEST(SegmenterSchedule, AChangedSegmentIsEmbeddedAgain) {
  TSG_REQUIRE_ENGINE();
  Segmenter segmenter(makeSmallModels(), makeConfig(ScheduleMode::kReuse));
  segmenter.segment(makeImage(0.0));
  const ColorImage changed = makeImage(0.1, {255, 60, 60});
  const Segmentation result = segmenter.segment(changed);
  const Segmentation exact = Segmenter(makeSmallModels(), {}).segment(changed);
  EXPECT_TRUE(result.embeddings.row(0).isApprox(exact.embeddings.row(0)));
  EXPECT_EQ(segmenter.counters().segments_reused, 1U);
}

TEST(SegmenterSchedule, ADroppedSegmentIsNotInTheResult) {
  TSG_REQUIRE_ENGINE();
  SegmenterConfig config = makeConfig(ScheduleMode::kReuse);
  config.schedule.max_crops_per_frame = 2;
  Segmenter segmenter(makeSmallModels(), config);
  const Segmentation exact = Segmenter(makeSmallModels(), {}).segment(makeImage(0.0));
  const Segmentation first = segmenter.segment(makeImage(0.0));
  first.validate();
  ASSERT_EQ(first.numSegments(), 1U);
  EXPECT_EQ(segmenter.counters().segments_dropped, 1U);
  // The red one is larger and stays, or the green one: the mask tells which.
  const int kept = static_cast<int>(exact.labels.at<std::uint16_t>(
      cv::Point(cv::boundingRect(first.labels == 1).tl() + cv::Point(5, 5))));
  ASSERT_GT(kept, 0);
  EXPECT_EQ(cv::norm(first.labels == 1, exact.labels == kept, cv::NORM_INF), 0.0);
  EXPECT_TRUE(first.embeddings.row(0).isApprox(exact.embeddings.row(kept - 1)));
  EXPECT_EQ(first.confidences[0], exact.confidences[static_cast<std::size_t>(kept - 1)]);
  EXPECT_EQ(segmenter.segment(makeImage(0.1)).numSegments(), 2U);
}

TEST(SegmenterSchedule, WithoutSegmentEmbeddingsNothingIsDropped) {
  TSG_REQUIRE_ENGINE();
  SegmenterConfig config = makeConfig(ScheduleMode::kReuse);
  config.embed_crop = config.embed_masked_crop = false;
  config.schedule.max_crops_per_frame = 1;
  EXPECT_EQ(Segmenter(makeSmallModels(), config).segment(makeImage(0.0)).numSegments(), 2U);
}

}  // namespace
}  // namespace tsg::segmentation
