// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/letterbox.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace tsg::segmentation {
namespace {

cv::Mat makeNoise(cv::Size size, int seed) {
  cv::Mat image(size, CV_8UC3);
  cv::RNG random(static_cast<std::uint64_t>(seed));
  random.fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

std::vector<float> fill(const cv::Mat& image, ColorOrder order, const Letterbox& letterbox) {
  const auto side = static_cast<std::size_t>(letterbox.input_size_px);
  std::vector<float> tensor(3 * side * side, -1.0F);
  fillLetterboxTensor({{}, image, order, nullptr}, letterbox, tensor.data());
  return tensor;
}

/// Bilinear interpolation in double at a letterbox pixel, edges repeated.
double sampleBilinear(const cv::Mat& image, double u, double v, int channel) {
  const auto value = [&](int x, int y) {
    const int cx = std::min(std::max(x, 0), image.cols - 1);
    const int cy = std::min(std::max(y, 0), image.rows - 1);
    return static_cast<double>(image.at<cv::Vec3b>(cy, cx)[channel]);
  };
  const int x = static_cast<int>(std::floor(u));
  const int y = static_cast<int>(std::floor(v));
  const double fx = u - x;
  const double fy = v - y;
  return (1 - fy) * ((1 - fx) * value(x, y) + fx * value(x + 1, y)) +
         fy * ((1 - fx) * value(x, y + 1) + fx * value(x + 1, y + 1));
}

TEST(Letterbox, AVgaImageNeedsNoScalingAt640) {
  const Letterbox letterbox = computeLetterbox({640, 480}, 640);
  EXPECT_EQ(letterbox.content_px, cv::Rect(0, 80, 640, 480));
  EXPECT_DOUBLE_EQ(letterbox.scale_x, 1.0);
  EXPECT_DOUBLE_EQ(letterbox.scale_y, 1.0);
}

TEST(Letterbox, EveryImageFitsCentredWithAtMostOnePixelOfSlack) {
  std::mt19937 random(7);
  for (int i = 0; i < 300; ++i) {
    const cv::Size size(1 + static_cast<int>(random() % 8000),
                        1 + static_cast<int>(random() % 8000));
    const Letterbox letterbox = computeLetterbox(size, 640);
    const cv::Rect content = letterbox.content_px;
    EXPECT_EQ(std::max(content.width, content.height), 640);
    EXPECT_EQ(content & cv::Rect(0, 0, 640, 640), content);
    EXPECT_LE(std::abs(640 - content.width - 2 * content.x), 1);
    EXPECT_LE(std::abs(640 - content.height - 2 * content.y), 1);
    const double exact = 640.0 / std::max(size.width, size.height);
    EXPECT_LE(std::abs(content.width - std::max(1.0, size.width * exact)), 0.5 + 1e-9);
    EXPECT_LE(std::abs(content.height - std::max(1.0, size.height * exact)), 0.5 + 1e-9);
  }
}

TEST(Letterbox, TensorHoldsPixelsInZeroToOneAndGreyBesideThem) {
  const cv::Mat image = makeNoise({64, 40}, 3);
  const auto tensor = fill(image, ColorOrder::kRgb, computeLetterbox(image.size(), 64));
  for (int v = 0; v < 64; ++v) {
    for (int u = 0; u < 64; ++u) {
      for (int c = 0; c < 3; ++c) {
        const bool inside = v >= 12 && v < 52;
        const double byte = inside ? image.at<cv::Vec3b>(v - 12, u)[c] : 114.0;
        ASSERT_NEAR(tensor[static_cast<std::size_t>((c * 64 + v) * 64 + u)], byte / 255.0, 1e-6);
      }
    }
  }
}

TEST(Letterbox, ColourOrderDoesNotMatter) {
  const cv::Mat rgb = makeNoise({50, 70}, 4);
  cv::Mat bgr = rgb.clone();
  for (auto& pixel : cv::Mat_<cv::Vec3b>(bgr)) std::swap(pixel[0], pixel[2]);
  const Letterbox letterbox = computeLetterbox(rgb.size(), 64);
  EXPECT_EQ(fill(rgb, ColorOrder::kRgb, letterbox), fill(bgr, ColorOrder::kBgr, letterbox));
}

TEST(Letterbox, ScaledImagesAreInterpolatedBilinearly) {
  for (const cv::Size size : {cv::Size(100, 37), cv::Size(23, 51)}) {
    const cv::Mat image = makeNoise(size, size.width);
    const Letterbox letterbox = computeLetterbox(size, 64);
    const auto tensor = fill(image, ColorOrder::kRgb, letterbox);
    const cv::Rect content = letterbox.content_px;
    for (int v = 0; v < content.height; ++v) {
      for (int u = 0; u < content.width; ++u) {
        const double expected = sampleBilinear(image, (u + 0.5) / letterbox.scale_x - 0.5,
                                               (v + 0.5) / letterbox.scale_y - 0.5, 1);
        const int index = (64 + v + content.y) * 64 + u + content.x;
        ASSERT_NEAR(tensor[static_cast<std::size_t>(index)], expected / 255.0, 1.5 / 255.0);
      }
    }
  }
}

TEST(Letterbox, APartOfALargerImageIsReadWithItsStride) {
  const cv::Mat whole = makeNoise({80, 80}, 5);
  const cv::Mat part = whole(cv::Rect(9, 11, 64, 48));
  const Letterbox letterbox = computeLetterbox(part.size(), 64);
  EXPECT_EQ(fill(part, ColorOrder::kRgb, letterbox),
            fill(part.clone(), ColorOrder::kRgb, letterbox));
}

TEST(Letterbox, SizesThatAreNotPositiveAreRefused) {
  EXPECT_THROW(computeLetterbox({0, 5}, 64), std::invalid_argument);
  EXPECT_THROW(computeLetterbox({5, 5}, 0), std::invalid_argument);
}

}  // namespace
}  // namespace tsg::segmentation
