// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/appearance.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace tsg::segmentation {
namespace {

constexpr int kLabel = 3;

/// An image in one colour, and labels in which `box` (or an ellipse in it) is the segment.
struct Scene {
  explicit Scene(const cv::Rect& segment_box, bool ellipse = false)
      : box(segment_box), labels(480, 640, CV_16UC1, cv::Scalar(0)) {
    if (ellipse) {
      const cv::Point center(box.x + box.width / 2, box.y + box.height / 2);
      cv::ellipse(labels, center, {box.width / 2 - 1, box.height / 2 - 1}, 0, 0, 360,
                  cv::Scalar(kLabel), cv::FILLED);
      box = cv::boundingRect(labels == kLabel);
    } else {
      labels(box) = cv::Scalar(kLabel);
    }
  }
  Appearance look(ColorOrder order = ColorOrder::kRgb) const {
    return computeAppearance({{}, image, order, nullptr}, labels, box, kLabel);
  }

  cv::Rect box;
  cv::Mat labels;
  cv::Mat image{480, 640, CV_8UC3, cv::Scalar(10, 20, 30)};
};

TEST(Appearance, HoldsTheMeanColourAndShareOfEachCellOfASmallSegment) {
  Scene scene({100, 50, 16, 16});
  cv::randu(scene.image, 0, 256);
  scene.labels(cv::Rect(102, 50, 1, 2)) = 7;  // half of cell 1 belongs to another segment
  const Appearance look = scene.look();
  EXPECT_EQ(look.size_px, cv::Size(16, 16));
  for (int cell = 0; cell < 64; ++cell) {
    const cv::Rect pixels(100 + cell % 8 * 2, 50 + cell / 8 * 2, 2, 2);
    const cv::Mat mask = scene.labels(pixels) == kLabel;
    const cv::Scalar mean = cv::mean(scene.image(pixels), mask);
    const auto i = static_cast<std::size_t>(cell);
    EXPECT_FLOAT_EQ(look.coverage[i], cell == 1 ? 0.5F : 1.0F);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(look.rgb_8bit[i][static_cast<std::size_t>(c)], mean[c], 1e-4);
    }
  }
}

TEST(Appearance, DoesNotDependOnPlaceOrColourOrder) {
  const Scene here({20, 30, 90, 61}, true);
  Scene there({300, 401 - 61, 90, 61}, true);
  cv::cvtColor(there.image, there.image, cv::COLOR_RGB2BGR);
  EXPECT_EQ(computeMaskIou(here.look(), there.look(ColorOrder::kBgr)), 1.0);
  EXPECT_EQ(computeColorChange(here.look(), there.look(ColorOrder::kBgr)), 0.0);
}

/// Of boxes and ellipses of different sizes laid upon each other at a corner of their boxes.
TEST(ComputeMaskIou, IsNearTheIouOfThePixels) {
  cv::RNG random(5);
  for (int round = 0; round < 50; ++round) {
    const cv::Size first(random.uniform(40, 300), random.uniform(40, 300));
    const cv::Size second(first.width * random.uniform(70, 101) / 100,
                          first.height * random.uniform(70, 101) / 100);
    const bool ellipses = round % 2 == 1;
    const Scene a({{10, 10}, first}, ellipses);
    const Scene b({{10, 10}, second}, ellipses);
    const cv::Mat mask_a = a.labels(a.box) == kLabel;
    cv::Mat mask_b;  // centred upon the other
    cv::copyMakeBorder(b.labels(b.box) == kLabel, mask_b, (a.box.height - b.box.height) / 2,
                       (a.box.height - b.box.height + 1) / 2, (a.box.width - b.box.width) / 2,
                       (a.box.width - b.box.width + 1) / 2, cv::BORDER_CONSTANT, 0);
    const double truth =
        static_cast<double>(cv::countNonZero(mask_a & mask_b)) / cv::countNonZero(mask_a | mask_b);
    EXPECT_NEAR(computeMaskIou(a.look(), b.look()), truth, 0.06) << first << second << ellipses;
    EXPECT_EQ(computeMaskIou(a.look(), b.look()), computeMaskIou(b.look(), a.look()));
  }
}

TEST(ComputeColorChange, IsTheMeanDifferenceOfTheChannels) {
  const Scene before({100, 100, 80, 40}, true);
  Scene after = before;
  after.image = before.image.clone();
  after.image += cv::Scalar(30, 0, 9);
  EXPECT_NEAR(computeColorChange(before.look(), after.look()), 13.0, 1e-4);
  after.image = before.image.clone();
  after.image(cv::Rect(100, 100, 40, 40)) += cv::Scalar(60, 60, 60);  // the left half only
  EXPECT_NEAR(computeColorChange(before.look(), after.look()), 30.0, 1.5);
}

TEST(ComputeColorChange, OfMasksWithoutACommonCellIsTheGreatest) {
  Scene left({0, 0, 64, 64});
  Scene right = left;
  left.labels(cv::Rect(32, 0, 32, 64)) = 0;
  right.labels(cv::Rect(0, 0, 32, 64)) = 0;
  EXPECT_EQ(computeColorChange(left.look(), right.look()), 255.0);
  EXPECT_EQ(computeMaskIou(left.look(), right.look()), 0.0);
}

}  // namespace
}  // namespace tsg::segmentation
