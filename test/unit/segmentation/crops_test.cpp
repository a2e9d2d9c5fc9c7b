// SPDX-License-Identifier: BSD-3-Clause
// Numbers computed by test/data/pillow_reference.py with Pillow 9.4 (Pillow 13 differs from it by
// one grey level in two of the tall images).
#include <gtest/gtest.h>

#include "segmentation/resampling.h"
#include "task_scene_graph/segmentation/image_encoder.h"

namespace tsg::segmentation {
namespace {

struct Checksums {
  std::int64_t sum = 0;
  std::int64_t weighted = 0;
};

bool operator==(const Checksums& a, const Checksums& b) {
  return a.sum == b.sum && a.weighted == b.weighted;
}

std::ostream& operator<<(std::ostream& out, const Checksums& sums) {
  return out << '{' << sums.sum << ", " << sums.weighted << '}';
}

cv::Mat makePattern(int width, int height) {
  cv::Mat image(height, width, CV_8UC3);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      for (int c = 0; c < 3; ++c) {
        const int value = u * 7 + v * 13 + c * 29 + u * v / 5 + ((u / 9) ^ (v / 7)) * 31;
        image.at<cv::Vec3b>(v, u)[c] = static_cast<std::uint8_t>(value % 256);
      }
    }
  }
  return image;
}

Checksums computeChecksums(const cv::Mat& image) {
  const cv::Mat bytes = image.reshape(1, 1);
  Checksums sums;
  for (int i = 0; i < bytes.cols; ++i) {
    sums.sum += bytes.at<std::uint8_t>(i);
    sums.weighted += bytes.at<std::uint8_t>(i) * (1 + i % 1009);
  }
  return sums;
}

TEST(ResizeBicubic, IsBitIdenticalToPillow) {
  const struct {
    cv::Size source;
    cv::Size resized;
    Checksums expected;
  } cases[] = {
      {{40, 30}, {17, 11}, {73878, 20545315}}, {{40, 30}, {64, 48}, {1212878, 603874151}},
      {{13, 90}, {3, 5}, {5759, 128460}},      {{7, 5}, {7, 9}, {14539, 1597948}},
      {{1, 1}, {8, 8}, {5568, 541024}},        {{160, 120}, {31, 24}, {285039, 132837743}},
  };
  for (const auto& [source, resized, expected] : cases) {
    const cv::Mat image = makePattern(source.width, source.height);
    const cv::Mat result = resizeBicubic(image, resized, {{0, 0}, resized});
    EXPECT_EQ(computeChecksums(result), expected) << source << " to " << resized;
  }
}

TEST(ResizeBicubic, AWindowIsThatPartOfTheWhole) {
  const cv::Mat image = makePattern(50, 41);
  const cv::Size resized(33, 70);
  const cv::Mat whole = resizeBicubic(image, resized, {{0, 0}, resized});
  const cv::Rect window(7, 30, 20, 25);
  EXPECT_EQ(cv::norm(resizeBicubic(image, resized, window), whole(window), cv::NORM_INF), 0.0);
}

TEST(ResizeBicubic, TheSameSizeGivesTheSameImage) {
  const cv::Mat image = makePattern(19, 23);
  EXPECT_EQ(cv::norm(resizeBicubic(image, image.size(), {{0, 0}, image.size()}), image), 0.0);
}

TEST(ResizeBicubic, WrongTypesAndWindowsAreRefused) {
  const cv::Mat image = makePattern(8, 8);
  EXPECT_THROW(resizeBicubic(image, {4, 4}, {1, 0, 4, 4}), std::invalid_argument);
  EXPECT_THROW(resizeBicubic(image, {0, 4}, {0, 0, 0, 4}), std::invalid_argument);
  EXPECT_THROW(resizeBicubic(cv::Mat(), {4, 4}, {0, 0, 4, 4}), std::invalid_argument);
  EXPECT_THROW(resizeBicubic(cv::Mat::zeros(8, 8, CV_8UC4), {4, 4}, {0, 0, 4, 4}),
               std::invalid_argument);
}

cv::Mat makeLabels(int width, int height) {
  cv::Mat labels(height, width, CV_16UC1);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      labels.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>((u / 5 + v / 4) % 3);
    }
  }
  return labels;
}

TEST(CropToSquare, EqualsTorchvisionOnPillowImages) {
  const struct {
    cv::Rect box;
    Checksums center, masked, squashed;
  } cases[] = {
      {{0, 0, 97, 61}, {397778, 199095559}, {134754, 68417846}, {394361, 197170679}},
      {{10, 5, 20, 50}, {355614, 174866992}, {108009, 55447225}, {382335, 193407464}},
      {{3, 7, 60, 13}, {362027, 180285513}, {125529, 62199558}, {426620, 211236866}},
      {{90, 55, 7, 6}, {378677, 185848292}, {235221, 120375924}, {376501, 185181419}},
  };
  const cv::Mat image = makePattern(97, 61);
  const cv::Mat labels = makeLabels(97, 61);
  for (const auto& expected : cases) {
    const auto sumsOf = [&](std::uint16_t label, CropFit fit) {
      return computeChecksums(cropToSquare(image, labels, {expected.box, label}, fit, 32));
    };
    EXPECT_EQ(sumsOf(0, CropFit::kCenterCrop), expected.center) << expected.box;
    EXPECT_EQ(sumsOf(2, CropFit::kCenterCrop), expected.masked) << expected.box;
    EXPECT_EQ(sumsOf(0, CropFit::kSquash), expected.squashed) << expected.box;
  }
}

TEST(CropToSquare, PaddingKeepsTheWholeCropAndAddsBlackBesideIt) {
  const cv::Mat image = makePattern(97, 61);
  const cv::Mat square = cropToSquare(image, {}, {{10, 20, 64, 16}, 0}, CropFit::kPad, 32);
  const cv::Mat expected = resizeBicubic(image(cv::Rect(10, 20, 64, 16)), {32, 8}, {0, 0, 32, 8});
  EXPECT_EQ(cv::norm(square.rowRange(12, 20), expected, cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::norm(square.rowRange(0, 12)), 0.0);
  EXPECT_EQ(cv::norm(square.rowRange(20, 32)), 0.0);
}

TEST(CropToSquare, ACropOneHundredTimesAsLongAsWideWorks) {
  const cv::Mat image = makePattern(640, 3);
  for (const CropFit fit : {CropFit::kCenterCrop, CropFit::kSquash, CropFit::kPad}) {
    const cv::Mat square = cropToSquare(image, {}, {{0, 1, 640, 1}, 0}, fit, 224);
    EXPECT_EQ(square.size(), cv::Size(224, 224));
    EXPECT_GT(cv::norm(square), 0.0);
  }
}

TEST(CropToSquare, BoxesOutsideTheImageAreRefused) {
  const cv::Mat image = makePattern(20, 10);
  EXPECT_THROW(cropToSquare(image, {}, {{15, 0, 6, 5}, 0}, CropFit::kSquash, 8),
               std::invalid_argument);
  EXPECT_THROW(cropToSquare(image, {}, {{3, 3, 0, 5}, 0}, CropFit::kSquash, 8),
               std::invalid_argument);
}

TEST(PlanBatches, EveryCropIsInOneBatchOfAnAllowedSize) {
  for (const int max_batch : {1, 4, 6, 8}) {
    for (const bool pad : {false, true}) {
      for (int n = 0; n < 40; ++n) {
        int used = 0;
        int wasted = 0;
        for (const Batch& batch : planBatches(n, max_batch, pad)) {
          const bool is_power = (batch.size & (batch.size - 1)) == 0;
          EXPECT_TRUE(batch.size == max_batch || (is_power && batch.size < max_batch));
          EXPECT_GT(batch.used, 0);
          used += batch.used;
          wasted += batch.size - batch.used;
        }
        EXPECT_EQ(used, n);
        EXPECT_LE(wasted, pad ? std::max(0, n % max_batch - 1) : 0);
      }
    }
  }
}

}  // namespace
}  // namespace tsg::segmentation
