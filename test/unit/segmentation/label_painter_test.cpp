// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/label_painter.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <random>

namespace tsg::segmentation {
namespace {

SegmentMask makeFilled(const cv::Rect& box, float score) {
  return {box, cv::Mat::ones(box.size(), CV_8UC1), box.area(), score};
}

/// Blobs with ragged edges and specks.
std::vector<SegmentMask> makeRandomMasks(unsigned seed, cv::Size size, int count) {
  std::mt19937 random(seed);
  std::vector<SegmentMask> masks;
  for (int i = 0; i < count; ++i) {
    const int x = static_cast<int>(random() % static_cast<unsigned>(size.width - 4));
    const int y = static_cast<int>(random() % static_cast<unsigned>(size.height - 4));
    const int width = 1 + static_cast<int>(random() % static_cast<unsigned>(size.width - x));
    const int height = 1 + static_cast<int>(random() % static_cast<unsigned>(size.height - y));
    SegmentMask mask = makeFilled({x, y, width, height}, 1.0F - 0.01F * static_cast<float>(i));
    for (auto& pixel : cv::Mat_<std::uint8_t>(mask.mask)) pixel = random() % 20 != 0;
    mask.area_px = cv::countNonZero(mask.mask);
    masks.push_back(mask);
  }
  return masks;
}

/// For every pixel the covering mask of smallest area (ties: the earlier one), counted from 1.
cv::Mat1w paintByDefinition(const std::vector<SegmentMask>& masks, cv::Size size) {
  cv::Mat1w labels(size, std::uint16_t{0});
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      int smallest = size.area() + 1;
      for (std::size_t i = 0; i < masks.size(); ++i) {
        const cv::Point inside = cv::Point(u, v) - masks[i].box_px.tl();
        const bool covers =
            masks[i].box_px.contains({u, v}) && masks[i].mask.at<std::uint8_t>(inside) != 0;
        if (!covers || masks[i].area_px >= smallest) continue;
        smallest = masks[i].area_px;
        labels(v, u) = static_cast<std::uint16_t>(i + 1);
      }
    }
  }
  return labels;
}

TEST(PaintLabels, TheSmallerMaskWinsOverlaps) {
  const cv::Size size(40, 30);
  const auto masks = makeRandomMasks(1, size, 12);
  const LabelledSegments segments = paintLabels(masks, size, false, 0);
  const cv::Mat1w expected = paintByDefinition(masks, size);
  ASSERT_EQ(segments.scores.size(), 12U) << "the comparison assumes that no mask vanished";
  EXPECT_EQ(cv::norm(segments.labels, expected, cv::NORM_INF), 0.0);
}

TEST(PaintLabels, OfEqualMasksTheBetterOneWins) {
  const auto segments = paintLabels(
      {makeFilled({2, 2, 5, 5}, 0.9F), makeFilled({2, 2, 5, 5}, 0.8F)}, {10, 10}, false, 0);
  ASSERT_EQ(segments.scores.size(), 1U);  // the other is covered entirely
  EXPECT_EQ(segments.scores[0], 0.9F);
}

TEST(PaintLabels, RefiningIsAnOpeningOfEverySegment) {
  const cv::Size size(60, 45);
  const auto masks = makeRandomMasks(2, size, 9);
  const cv::Mat1w painted = paintByDefinition(masks, size);
  const LabelledSegments segments = paintLabels(masks, size, true, 0);
  const cv::Mat square = cv::Mat::ones(3, 3, CV_8UC1);
  std::uint16_t label = 0;
  for (int i = 1; i <= 9; ++i) {
    cv::Mat opened;
    cv::erode(painted == i, opened, square, {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
    cv::dilate(opened, opened, square);
    if (cv::countNonZero(opened) == 0) continue;
    ++label;
    EXPECT_EQ(cv::norm(opened, segments.labels == label, cv::NORM_INF), 0.0) << "segment " << i;
    EXPECT_EQ(segments.scores[label - 1U], masks[static_cast<std::size_t>(i - 1)].score);
  }
  EXPECT_EQ(segments.scores.size(), label);
  EXPECT_GT(label, 2);
}

TEST(PaintLabels, BoxesAndAreasAreThoseOfTheLabels) {
  const cv::Size size(60, 45);
  const auto segments = paintLabels(makeRandomMasks(3, size, 20), size, true, 5);
  ASSERT_GT(segments.scores.size(), 3U);
  for (std::size_t i = 0; i < segments.scores.size(); ++i) {
    const cv::Mat mask = segments.labels == static_cast<double>(i + 1);
    EXPECT_EQ(segments.areas_px[i], cv::countNonZero(mask));
    EXPECT_EQ(segments.boxes_px[i], cv::boundingRect(mask));
    EXPECT_GE(segments.areas_px[i], 5);
  }
}

TEST(PaintLabels, SegmentsBelowTheSmallestAreaAreDroppedAndLabelsStayDense) {
  const std::vector<SegmentMask> masks = {makeFilled({0, 0, 3, 3}, 0.9F),
                                          makeFilled({5, 0, 5, 5}, 0.8F),
                                          makeFilled({12, 0, 4, 4}, 0.7F)};
  const auto segments = paintLabels(masks, {20, 10}, false, 10);
  EXPECT_EQ(segments.scores, (std::vector<float>{0.8F, 0.7F}));
  EXPECT_EQ(segments.labels.at<std::uint16_t>(1, 1), 0);
  EXPECT_EQ(segments.labels.at<std::uint16_t>(1, 6), 1);
  EXPECT_EQ(segments.labels.at<std::uint16_t>(1, 13), 2);
}

TEST(DropSegments, TheOthersKeepTheirPixelsInDenseLabels) {
  const LabelledSegments before = paintLabels(makeRandomMasks(9, {60, 50}, 8), {60, 50}, false, 1);
  const std::size_t count = before.scores.size();
  ASSERT_GE(count, 5U);
  LabelledSegments after = before;
  after.labels = before.labels.clone();
  dropSegments({0, 3}, after);
  ASSERT_EQ(after.scores.size(), count - 2);
  int label = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i == 0 || i == 3) continue;
    const auto kept = static_cast<std::size_t>(label++);
    EXPECT_EQ(cv::norm(after.labels == label, before.labels == static_cast<double>(i + 1)), 0.0);
    EXPECT_EQ(after.scores[kept], before.scores[i]);
    EXPECT_EQ(after.boxes_px[kept], before.boxes_px[i]);
    EXPECT_EQ(after.areas_px[kept], before.areas_px[i]);
  }
  EXPECT_EQ(cv::countNonZero(after.labels),
            cv::countNonZero(before.labels) - before.areas_px[0] - before.areas_px[3]);
}

TEST(PaintLabels, NoMaskGivesAnImageOfZeros) {
  const auto segments = paintLabels({}, {20, 10}, true, 0);
  EXPECT_EQ(segments.labels.size(), cv::Size(20, 10));
  EXPECT_EQ(cv::countNonZero(segments.labels), 0);
  EXPECT_TRUE(segments.scores.empty());
}

TEST(PaintLabels, ImagesOfOnePixelAreRefinedAway) {
  const auto segments = paintLabels({makeFilled({0, 0, 1, 1}, 0.5F)}, {1, 1}, true, 0);
  EXPECT_TRUE(segments.scores.empty());
}

TEST(PaintLabels, MoreMasksThanLabelsAreRefused) {
  EXPECT_THROW(paintLabels(std::vector<SegmentMask>(65536), {4, 4}, false, 0),
               std::invalid_argument);
}

}  // namespace
}  // namespace tsg::segmentation
