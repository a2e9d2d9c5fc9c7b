// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/appearance.h"

#include <algorithm>
#include <cmath>

namespace tsg::segmentation {
namespace {

constexpr int kMostSamplesPerSide = 64;

/// Ratio of the smaller to the larger of two sides.
double computeRatio(int a, int b) {
  return static_cast<double>(std::min(a, b)) / static_cast<double>(std::max(a, b));
}

/// Of the whole mask; negative if it is empty.
std::array<double, 3> computeMeanColor(const Appearance& appearance) {
  std::array<double, 3> sum{};
  double weights = 0.0;
  for (std::size_t cell = 0; cell < Appearance::kCells; ++cell) {
    const auto weight = static_cast<double>(appearance.coverage[cell]);
    weights += weight;
    for (std::size_t c = 0; c < 3; ++c) {
      sum[c] += weight * static_cast<double>(appearance.rgb_8bit[cell][c]);
    }
  }
  for (double& value : sum) value = weights > 0.0 ? value / weights : -1.0;
  return sum;
}

/// Sums per cell while pixels are read.
struct CellSums {
  std::array<int, Appearance::kCells> samples{};
  std::array<int, Appearance::kCells> covered{};
  std::array<std::array<int, 3>, Appearance::kCells> color{};
};

CellSums readCells(const cv::Mat& image, const cv::Mat& labels, const cv::Rect& box,
                   std::uint16_t label) {
  constexpr int kSide = static_cast<int>(Appearance::kSide);
  const int step_u = std::max(1, box.width / kMostSamplesPerSide);
  const int step_v = std::max(1, box.height / kMostSamplesPerSide);
  CellSums sums;
  for (int v = step_v / 2; v < box.height; v += step_v) {
    const std::uint16_t* label_row = labels.ptr<std::uint16_t>(box.y + v) + box.x;
    const cv::Vec3b* color_row = image.ptr<cv::Vec3b>(box.y + v) + box.x;
    const int cell_row = v * kSide / box.height * kSide;
    for (int u = step_u / 2; u < box.width; u += step_u) {
      const auto cell = static_cast<std::size_t>(cell_row + u * kSide / box.width);
      ++sums.samples[cell];
      if (label_row[u] != label) continue;
      ++sums.covered[cell];
      for (std::size_t c = 0; c < 3; ++c) sums.color[cell][c] += color_row[u][static_cast<int>(c)];
    }
  }
  return sums;
}

}  // namespace

Appearance computeAppearance(const ColorImage& color, const cv::Mat& labels, const cv::Rect& box_px,
                             std::uint16_t label) {
  const CellSums sums = readCells(color.image, labels, box_px, label);
  const bool is_rgb = color.order == ColorOrder::kRgb;
  Appearance appearance;
  appearance.size_px = box_px.size();
  for (std::size_t cell = 0; cell < Appearance::kCells; ++cell) {
    if (sums.covered[cell] == 0) continue;
    const auto covered = static_cast<float>(sums.covered[cell]);
    appearance.coverage[cell] = covered / static_cast<float>(sums.samples[cell]);
    for (std::size_t c = 0; c < 3; ++c) {
      const int sum = sums.color[cell][is_rgb ? c : 2 - c];
      appearance.rgb_8bit[cell][c] = static_cast<float>(sum) / covered;
    }
  }
  return appearance;
}

double computeMaskIou(const Appearance& a, const Appearance& b) {
  double intersection = 0.0;
  double both = 0.0;
  for (std::size_t cell = 0; cell < Appearance::kCells; ++cell) {
    intersection += static_cast<double>(std::min(a.coverage[cell], b.coverage[cell]));
    both += static_cast<double>(std::max(a.coverage[cell], b.coverage[cell]));
  }
  if (both == 0.0) return 0.0;
  return intersection / both * computeRatio(a.size_px.width, b.size_px.width) *
         computeRatio(a.size_px.height, b.size_px.height);
}

double computeColorChange(const Appearance& a, const Appearance& b) {
  double change = 0.0;
  double weights = 0.0;
  for (std::size_t cell = 0; cell < Appearance::kCells; ++cell) {
    const auto weight = static_cast<double>(std::min(a.coverage[cell], b.coverage[cell]));
    double difference = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      difference += static_cast<double>(std::abs(a.rgb_8bit[cell][c] - b.rgb_8bit[cell][c]));
    }
    change += weight * difference / 3.0;
    weights += weight;
  }
  return weights > 0.0 ? change / weights : 255.0;
}

double computeMeanColorChange(const Appearance& a, const Appearance& b) {
  const auto one = computeMeanColor(a);
  const auto other = computeMeanColor(b);
  if (one[0] < 0.0 || other[0] < 0.0) return 255.0;
  double change = 0.0;
  for (std::size_t c = 0; c < 3; ++c) change += std::abs(one[c] - other[c]);
  return change / 3.0;
}

}  // namespace tsg::segmentation
