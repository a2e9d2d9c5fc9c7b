// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/depth_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "synthetic_scene.h"
#include "task_scene_graph/config/config.h"

namespace tsg::mapping {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
const CameraModel kCamera{64, 48, 60.0, 62.0, 31.5, 23.5};

DepthImage makeDepth(const cv::Mat& depth_m) { return {depth_m, 1.0, nullptr}; }

cv::Mat makeWall(float depth_m) { return {48, 64, CV_32FC1, cv::Scalar(depth_m)}; }

/// A wall at 3 m behind a panel at 1 m that covers the columns below 32.
cv::Mat makePanel() {
  cv::Mat depth_m = makeWall(3.0F);
  depth_m.colRange(0, 32).setTo(1.0F);
  return depth_m;
}

DepthFilterConfig makeOff() {
  DepthFilterConfig config;
  config.reject_flying_pixels = false;
  config.min_support_px = 0;
  return config;
}

int countDifferent(const cv::Mat& a, const cv::Mat& b) { return cv::countNonZero(a != b); }

/// The definitions of the class's documentation, one pixel at a time.
bool isKeptByDefinition(const cv::Mat& depth_m, int u, int v, const DepthFilterConfig& config) {
  const auto at = [&](int column, int row) {
    const bool inside = column >= 0 && row >= 0 && column < depth_m.cols && row < depth_m.rows;
    return inside ? depth_m.at<float>(row, column) : 0.0F;
  };
  const float z = at(u, v);
  if (z == 0.0F) return false;
  const float step = static_cast<float>(std::min(0.5, config.max_slope / 60.0)) * z;
  const auto isFlying = [&](float a, float b) {
    return std::min(a, b) > 0.0F && z - std::min(a, b) > step && std::max(a, b) - z > step;
  };
  const bool flies = isFlying(at(u - 1, v), at(u + 1, v)) || isFlying(at(u, v - 1), at(u, v + 1));
  int support = 0;
  for (int i = 0; i < 9; ++i) {
    if (i != 4 && std::abs(at(u + i % 3 - 1, v + i / 3 - 1) - z) <= step) ++support;
  }
  return support >= config.min_support_px && !(flies && config.reject_flying_pixels);
}

TEST(DepthFilter, FollowsItsDefinitionsInEveryPixel) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> depth(0.4F, 4.0F);
  std::uniform_int_distribution<int> kind(0, 9);
  cv::Mat image = makeWall(2.0F);
  for (auto it = image.begin<float>(); it != image.end<float>(); ++it) {
    const int dice = kind(random);
    *it = dice == 0 ? 0.0F : dice < 4 ? depth(random) : *it;
  }
  DepthFilterConfig config;
  config.max_slope = 6.0;
  for (const int support : {0, 2, 5}) {
    config.min_support_px = support;
    DepthFilter filter(config);
    const auto filtered = filter.apply(makeDepth(image), kCamera);
    std::size_t kept = 0;
    for (int v = 0; v < image.rows; ++v) {
      for (int u = 0; u < image.cols; ++u) {
        const bool expected = isKeptByDefinition(image, u, v, config);
        EXPECT_EQ(filtered.at(u, v), expected ? image.at<float>(v, u) : 0.0F) << u << " " << v;
        kept += expected ? 1 : 0;
      }
    }
    const auto valid = static_cast<std::size_t>(cv::countNonZero(image));
    EXPECT_EQ(filter.counters().valid_readings, valid);
    EXPECT_EQ(filter.counters().rejected_readings, valid - kept);
    EXPECT_GT(valid - kept, 100U);
  }
}

TEST(DepthFilter, PixelsThatMixTwoSurfacesGoAndBothSurfacesStay) {
  const cv::Mat clean = makePanel();
  cv::Mat mixed = clean.clone();
  for (int v = 0; v < 48; ++v) {  // a ramp of two pixels, of another slope in each row
    mixed.at<float>(v, 32) = 1.4F + 0.005F * static_cast<float>(v);
    mixed.at<float>(v, 33) = 2.2F - 0.005F * static_cast<float>(v);
  }
  DepthFilterConfig config;
  config.max_slope = 5.0;
  cv::Mat expected = clean.clone();
  expected.colRange(32, 34).setTo(0.0F);
  EXPECT_EQ(countDifferent(DepthFilter(config).apply(makeDepth(mixed), kCamera).image, expected),
            0);
  EXPECT_EQ(countDifferent(DepthFilter(config).apply(makeDepth(clean), kCamera).image, clean), 0);
}

TEST(DepthFilter, SpecklesGoAndThinThingsStay) {
  cv::Mat depth_m = makeWall(3.0F);
  depth_m.col(20).setTo(1.0F);       // a pole
  depth_m.at<float>(24, 50) = 1.0F;  // a speckle
  const auto filtered = DepthFilter({}).apply(makeDepth(depth_m), kCamera);
  EXPECT_EQ(filtered.at(20, 24), 1.0F);
  EXPECT_EQ(filtered.at(50, 24), 0.0F);
  const cv::Range inner(1, 47);  // the two ends of the pole have one neighbour only
  EXPECT_EQ(countDifferent(filtered.image.rowRange(inner), depth_m.rowRange(inner)), 1);
}

TEST(DepthFilter, SlantedSurfacesUpToTheLimitStayWhole) {
  for (const double degrees : {0.0, 60.0, 80.0, 86.0}) {
    // A floor seen from 1 m above it, the view tilted down.
    const double tilt = (90.0 - degrees) * M_PI / 180.0;
    const auto floor = {test::makePlane({0, 0, 0}, {0, 0, 1}, {1, 1, 1})};
    CameraModel narrow = kCamera;
    narrow.fx_px = narrow.fy_px = 1000.0;  // all rays at nearly that angle
    const auto frame =
        test::render(floor, narrow,
                     test::lookAt({0, 0, 1}, {std::cos(tilt), 1e-6, 1.0 - std::sin(tilt)}))
            .frame;
    DepthFilter filter({});
    filter.apply(frame.depth, narrow);
    EXPECT_GT(filter.counters().valid_readings, 3000U);
    EXPECT_EQ(filter.counters().rejected_readings, 0U) << degrees;
  }
}

TEST(DepthFilter, MarginsAlongStepsAreDroppedOnBothSides) {
  for (const int margin_px : {1, 3}) {
    DepthFilterConfig config = makeOff();
    config.edge_margin_px = margin_px;
    cv::Mat expected = makePanel();
    expected.colRange(32 - margin_px, 32 + margin_px).setTo(0.0F);
    const auto filtered = DepthFilter(config).apply(makeDepth(makePanel()), kCamera);
    EXPECT_EQ(countDifferent(filtered.image, expected), 0) << margin_px;
  }
}

TEST(DepthFilter, BilateralSmoothsNoiseAndKeepsSteps) {
  cv::Mat noisy = makePanel();
  std::mt19937 random(5);
  std::normal_distribution<float> noise(0.0F, 0.01F);
  for (auto it = noisy.begin<float>(); it != noisy.end<float>(); ++it) *it += noise(random);
  noisy.at<float>(10, 10) = 0.0F;
  DepthFilterConfig config = makeOff();
  config.bilateral_radius_px = 2;
  const auto smooth = DepthFilter(config).apply(makeDepth(noisy), kCamera);
  EXPECT_EQ(smooth.at(10, 10), 0.0F);
  const cv::Mat valid = noisy > 0.0F;
  const double before = cv::norm(noisy, makePanel(), cv::NORM_L2, valid);
  EXPECT_LT(cv::norm(smooth.image, makePanel(), cv::NORM_L2, valid), 0.5 * before);
  EXPECT_LT(cv::norm(smooth.image, makePanel(), cv::NORM_INF, valid), 0.05);
}

TEST(DepthFilter, ReadsMillimetresAndKnowsEveryKindOfInvalid) {
  cv::Mat raw(48, 64, CV_16UC1, cv::Scalar(1500));
  raw.rowRange(0, 10).setTo(65535);
  raw.rowRange(10, 20).setTo(0);
  const auto from_raw = DepthFilter({}).apply({raw, 0.001, nullptr}, kCamera);
  cv::Mat metres = makeWall(1.5F);
  metres.rowRange(0, 10).setTo(kNan);
  metres.rowRange(10, 15).setTo(-1.0F);
  metres.rowRange(15, 20).setTo(std::numeric_limits<float>::infinity());
  const auto from_metres = DepthFilter({}).apply(makeDepth(metres), kCamera);
  cv::Mat expected = makeWall(1.5F);
  expected.rowRange(0, 20).setTo(0.0F);
  EXPECT_LT(cv::norm(from_raw.image, expected, cv::NORM_INF), 1e-6);
  EXPECT_EQ(countDifferent(from_metres.image, expected), 0);
}

TEST(DepthFilter, SwitchedOffItHandsBackTheSameImage) {
  const cv::Mat depth_m = makePanel();
  DepthFilter filter(makeOff());
  EXPECT_EQ(filter.apply(makeDepth(depth_m), kCamera).image.data, depth_m.data);
}

TEST(DepthFilter, DoesNotTouchItsArgumentAndFollowsTheImagesSize) {
  cv::Mat depth_m = makePanel();
  depth_m.at<float>(5, 5) = 2.0F;
  const cv::Mat before = depth_m.clone();
  DepthFilter filter({});
  const auto first = filter.apply(makeDepth(depth_m), kCamera);
  CameraModel small = kCamera;
  small.width_px = 30;
  const auto second = filter.apply(makeDepth(depth_m.colRange(0, 30)), small);
  EXPECT_EQ(countDifferent(depth_m, before), 0);
  EXPECT_EQ(countDifferent(first.image.colRange(0, 30), second.image), 0);
}

TEST(DepthFilter, BadConfigurationIsRejected) {
  DepthFilterConfig config;
  config.max_slope = 0.0;
  EXPECT_THROW(DepthFilter filter(config), config::ConfigError);
}

}  // namespace
}  // namespace tsg::mapping
