// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/overlay.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace tsg::segmentation {
namespace {

constexpr int kNumColors = 180;  // OpenCV's 8-bit hue has as many steps

/// Successive labels get colours far apart: hues almost a golden angle from each other.
std::array<cv::Vec3b, kNumColors> makePalette(ColorOrder order) {
  cv::Mat3b hsv(1, kNumColors);
  for (int i = 0; i < kNumColors; ++i) {
    hsv(0, i) = cv::Vec3b(static_cast<std::uint8_t>(i * 111 % kNumColors), 200, 255);
  }
  cv::Mat3b colors;
  const bool is_rgb = order == ColorOrder::kRgb;
  cv::cvtColor(hsv, colors, is_rgb ? cv::COLOR_HSV2RGB : cv::COLOR_HSV2BGR);
  std::array<cv::Vec3b, kNumColors> palette;
  for (int i = 0; i < kNumColors; ++i) palette[static_cast<std::size_t>(i)] = colors(0, i);
  return palette;
}

cv::Vec3b mix(const cv::Vec3b& a, const cv::Vec3b& b) {
  cv::Vec3b mean;
  for (int c = 0; c < 3; ++c) mean[c] = static_cast<std::uint8_t>((a[c] + b[c]) / 2);
  return mean;
}

void checkInputs(const cv::Mat& image, const cv::Mat& labels) {
  if (image.type() == CV_8UC3 && labels.type() == CV_16UC1 && image.size() == labels.size()) return;
  throw std::invalid_argument("image is " + std::to_string(image.cols) + "x" +
                              std::to_string(image.rows) + " " + cv::typeToString(image.type()) +
                              ", labels are " + std::to_string(labels.cols) + "x" +
                              std::to_string(labels.rows) + " " + cv::typeToString(labels.type()) +
                              ", expected CV_8UC3 and CV_16UC1 of one size");
}

}  // namespace

cv::Mat drawSegments(const cv::Mat& image, const cv::Mat& labels, ColorOrder order) {
  checkInputs(image, labels);
  const auto palette = makePalette(order);
  cv::Mat drawn = image.clone();
  for (int v = 0; v < labels.rows; ++v) {
    const std::uint16_t* here = labels.ptr<std::uint16_t>(v);
    const std::uint16_t* below = labels.ptr<std::uint16_t>(std::min(v + 1, labels.rows - 1));
    cv::Vec3b* pixel = drawn.ptr<cv::Vec3b>(v);
    for (int u = 0; u < labels.cols; ++u) {
      const int right = std::min(u + 1, labels.cols - 1);
      if (here[u] != here[right] || here[u] != below[u]) {
        pixel[u] = cv::Vec3b::all(255);
      } else if (here[u] != 0) {
        pixel[u] = mix(pixel[u], palette[here[u] % kNumColors]);
      }
    }
  }
  return drawn;
}

}  // namespace tsg::segmentation
