// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/mask_decoder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "task_scene_graph/segmentation/segmenter_layout.h"

namespace tsg::segmentation {
namespace {

/// Random outputs of a FastSAM-shaped network with a 64 px input.
struct FakeOutputs {
  static constexpr int kInput = 64;

  FakeOutputs(unsigned seed, int classes, int prototypes, int grid, int anchors)
      : predictions(static_cast<std::size_t>((4 + classes + prototypes) * anchors)),
        planes(static_cast<std::size_t>(prototypes * grid * grid)) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    std::uniform_real_distribution<float> unit(0.0F, 1.0F);
    for (float& value : predictions) value = normal(random);
    for (float& value : planes) value = normal(random);
    for (int a = 0; a < anchors; ++a) {
      at(0, a, anchors) = kInput * unit(random);
      at(1, a, anchors) = kInput * unit(random);
      at(2, a, anchors) = 4.0F + kInput * unit(random);
      at(3, a, anchors) = 4.0F + kInput * unit(random);
      for (int c = 0; c < classes; ++c) at(4 + c, a, anchors) = unit(random);
    }
    views = {{{1, 4 + classes + prototypes, anchors}, predictions.data(), nullptr},
             {{1, prototypes, grid, grid}, planes.data(), nullptr}};
  }
  float& at(int row, int anchor, int anchors) {
    return predictions[static_cast<std::size_t>(row * anchors + anchor)];
  }

  std::vector<float> predictions;
  std::vector<float> planes;
  std::vector<TensorView> views;
};

/// The mask logit at an image pixel, from the definition: all prototypes, full resolution, double.
double computeLogit(const RawDetections& raw, std::size_t anchor, const Letterbox& letterbox, int u,
                    int v) {
  const int grid = raw.prototype_size_px;
  const double cells_per_px = static_cast<double>(grid) / letterbox.input_size_px;
  const auto locate = [&](int pixel, double scale, int begin, int length) {
    double first = std::ceil(begin * cells_per_px);
    double last = std::floor((begin + length) * cells_per_px) - 1;
    if (first > last) {
      first = 0;
      last = grid - 1;
    }
    const double at = ((pixel + 0.5) * scale + begin) * cells_per_px - 0.5;
    return std::min(std::max(at, first), last);
  };
  const cv::Rect content = letterbox.content_px;
  const double x = locate(u, letterbox.scale_x, content.x, content.width);
  const double y = locate(v, letterbox.scale_y, content.y, content.height);
  const auto cell = [&](int cx, int cy) {
    double sum = 0.0;
    for (int k = 0; k < raw.num_prototypes; ++k) {
      const auto row = static_cast<std::size_t>(4 + raw.num_classes + k);
      const double weight = raw.predictions[row * raw.num_anchors + anchor];
      sum += weight *
             raw.prototypes[(k * grid + std::min(cy, grid - 1)) * grid + std::min(cx, grid - 1)];
    }
    return sum;
  };
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  const double fx = x - x0;
  const double fy = y - y0;
  return (1 - fy) * ((1 - fx) * cell(x0, y0) + fx * cell(x0 + 1, y0)) +
         fy * ((1 - fx) * cell(x0, y0 + 1) + fx * cell(x0 + 1, y0 + 1));
}

bool isInside(const cv::Rect2f& box, const Letterbox& letterbox, int u, int v) {
  const double left = (box.x - static_cast<double>(letterbox.content_px.x)) / letterbox.scale_x;
  const double top = (box.y - static_cast<double>(letterbox.content_px.y)) / letterbox.scale_y;
  return u >= left && u < left + box.width / letterbox.scale_x && v >= top &&
         v < top + box.height / letterbox.scale_y;
}

class DecodeMask : public ::testing::TestWithParam<std::tuple<cv::Size, int>> {};

TEST_P(DecodeMask, EqualsFullResolutionDecodingInsideTheBox) {
  const auto [image_size, grid] = GetParam();
  FakeOutputs outputs(11, 1, 6, grid, 40);
  const RawDetections raw = interpretOutputs(outputs.views, {}, "fake");
  const Letterbox letterbox = computeLetterbox(image_size, FakeOutputs::kInput);
  int compared = 0;
  for (const Detection& detection : findCandidates(raw, 0.0)) {
    const SegmentMask segment = decodeMask(raw, detection, letterbox);
    EXPECT_EQ(segment.area_px, segment.mask.empty() ? 0 : cv::countNonZero(segment.mask));
    for (int v = 0; v < image_size.height; ++v) {
      for (int u = 0; u < image_size.width; ++u) {
        const bool decoded =
            segment.box_px.contains({u, v}) &&
            segment.mask.at<std::uint8_t>(v - segment.box_px.y, u - segment.box_px.x) == 1;
        const double logit = computeLogit(raw, detection.anchor, letterbox, u, v);
        if (std::abs(logit) < 1e-4) continue;  // float and double may disagree about the sign
        ASSERT_EQ(decoded, logit > 0.0 && isInside(detection.box_px, letterbox, u, v))
            << "pixel " << u << ", " << v << " of anchor " << detection.anchor;
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 30 * image_size.area());
}

INSTANTIATE_TEST_SUITE_P(SizesAndGrids, DecodeMask,
                         ::testing::Combine(::testing::Values(cv::Size(64, 48), cv::Size(48, 64),
                                                              cv::Size(150, 61), cv::Size(20, 33),
                                                              cv::Size(90, 1), cv::Size(1, 1)),
                                            ::testing::Values(16, 32, 1)));

TEST(FindCandidates, KeepsWhatExceedsTheThresholdBestFirst) {
  FakeOutputs outputs(5, 1, 3, 4, 200);
  const auto candidates = findCandidates(interpretOutputs(outputs.views, {}, "fake"), 0.3);
  long expected = 0;
  for (int a = 0; a < 200; ++a) expected += outputs.at(4, a, 200) > 0.3F;
  EXPECT_EQ(static_cast<long>(candidates.size()), expected);
  EXPECT_TRUE(std::is_sorted(candidates.begin(), candidates.end(),
                             [](const auto& a, const auto& b) { return a.score > b.score; }));
}

TEST(FindCandidates, OfSeveralClassesTheGreatestScoreCounts) {
  FakeOutputs outputs(6, 3, 3, 4, 50);
  const RawDetections raw = interpretOutputs(outputs.views, {}, "fake");
  EXPECT_EQ(raw.num_classes, 3);
  const auto candidates = findCandidates(raw, 0.0);
  ASSERT_EQ(candidates.size(), 50U);
  for (const Detection& candidate : candidates) {
    const int a = static_cast<int>(candidate.anchor);
    EXPECT_EQ(candidate.score,
              std::max({outputs.at(4, a, 50), outputs.at(5, a, 50), outputs.at(6, a, 50)}));
  }
}

TEST(FindCandidates, ValuesThatAreNotFiniteAndEmptyBoxesAreDropped) {
  FakeOutputs outputs(7, 1, 3, 4, 5);
  outputs.at(4, 0, 5) = std::numeric_limits<float>::quiet_NaN();
  outputs.at(0, 1, 5) = std::numeric_limits<float>::infinity();
  outputs.at(2, 2, 5) = 0.0F;
  outputs.at(3, 3, 5) = -2.0F;
  const auto candidates = findCandidates(interpretOutputs(outputs.views, {}, "fake"), 0.0);
  ASSERT_EQ(candidates.size(), 1U);
  EXPECT_EQ(candidates[0].anchor, 4U);
}

TEST(DecodeMask, ABoxOutsideTheImageGivesAnEmptyMask) {
  FakeOutputs outputs(8, 1, 3, 16, 1);
  const RawDetections raw = interpretOutputs(outputs.views, {}, "fake");
  const Letterbox letterbox = computeLetterbox({64, 32}, 64);
  const SegmentMask segment = decodeMask(raw, {{3.0F, 2.0F, 20.0F, 9.0F}, 0.5F, 0}, letterbox);
  EXPECT_TRUE(segment.box_px.empty());  // the box lies in the grey above the image
  EXPECT_EQ(segment.area_px, 0);
}

double computeIou(const cv::Rect2f& a, const cv::Rect2f& b) {
  const double common = (a & b).area();
  return common / (static_cast<double>(a.area()) + b.area() - common);
}

TEST(SuppressOverlaps, KeepsExactlyThoseThatNoBetterKeptOneCovers) {
  FakeOutputs outputs(9, 1, 3, 4, 300);
  const auto candidates = findCandidates(interpretOutputs(outputs.views, {}, "fake"), 0.0);
  for (const double threshold : {0.3, 0.6, 0.85}) {
    const auto kept = suppressOverlaps(candidates, threshold, 1000);
    for (const Detection& candidate : candidates) {
      bool covered = false;
      bool is_kept = false;
      for (const Detection& better : kept) {
        is_kept |= better.anchor == candidate.anchor;
        if (better.score <= candidate.score) break;
        covered |= computeIou(better.box_px, candidate.box_px) > threshold + 1e-6;
      }
      EXPECT_NE(covered, is_kept) << "anchor " << candidate.anchor;
    }
    EXPECT_LT(kept.size(), candidates.size());
  }
}

TEST(SuppressOverlaps, EndsAtTheLargestNumberAllowed) {
  FakeOutputs outputs(9, 1, 3, 4, 300);
  const auto candidates = findCandidates(interpretOutputs(outputs.views, {}, "fake"), 0.0);
  const auto all = suppressOverlaps(candidates, 0.9, 1000);
  const auto few = suppressOverlaps(candidates, 0.9, 7);
  ASSERT_EQ(few.size(), 7U);
  for (std::size_t i = 0; i < 7; ++i) EXPECT_EQ(few[i].anchor, all[i].anchor);
}

}  // namespace
}  // namespace tsg::segmentation
