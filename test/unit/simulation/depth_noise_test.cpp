// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/depth_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "task_scene_graph/config/config.h"

namespace tsg::simulation {
namespace {

const CameraModel kCamera{200, 150, 164.0, 164.0, 99.5, 74.5};

cv::Mat makePlane(double depth_m) {
  return cv::Mat(kCamera.height_px, kCamera.width_px, CV_32FC1, cv::Scalar(depth_m));
}

cv::Mat measure(const cv::Mat& depth_m, const DepthNoiseConfig& config, std::int64_t frame = 0,
                int threads = 1) {
  return simulateDepthSensor(depth_m, kCamera, config, 5, frame, threads);
}

struct Statistics {
  double mean_m = 0.0;
  double deviation_m = 0.0;
  double missing = 0.0;
};

Statistics computeStatistics(const cv::Mat& measured) {
  Statistics s;
  double sum = 0.0;
  double squares = 0.0;
  int valid = 0;
  for (int v = 0; v < measured.rows; ++v) {
    for (int u = 0; u < measured.cols; ++u) {
      const double z = 0.001 * measured.at<std::uint16_t>(v, u);
      if (z <= 0.0) continue;
      ++valid;
      sum += z;
      squares += z * z;
    }
  }
  s.mean_m = sum / valid;
  s.deviation_m = std::sqrt(squares / valid - s.mean_m * s.mean_m);
  s.missing = 1.0 - valid / static_cast<double>(measured.total());
  return s;
}

TEST(DepthNoise, GrowsWithTheSquareOfTheDepthAndHasNoBias) {
  DepthNoiseConfig config;
  config.subpixel_px = 0.0;
  for (const double z : {0.5, 1.0, 2.0, 4.0}) {
    const Statistics s = computeStatistics(measure(makePlane(z), config));
    const double expected = config.axial_m + config.axial_per_m * z * z;
    EXPECT_NEAR(s.mean_m, z, 0.05 * expected + 1e-4);
    EXPECT_NEAR(s.deviation_m, expected, 0.05 * expected + 1e-4);
    EXPECT_EQ(s.missing, 0.0);
  }
}

TEST(DepthNoise, DisparityStepsLimitTheValues) {
  DepthNoiseConfig config;
  config.axial_m = 0.0;
  config.axial_per_m = 0.0;
  for (const double z : {0.7, 1.9, 3.3, 5.2}) {
    const cv::Mat measured = measure(makePlane(z), config);
    const double scale = kCamera.fx_px * config.baseline_m;
    const double step_m = z * z * config.subpixel_px / scale;
    const double got_m = 0.001 * measured.at<std::uint16_t>(75, 100);
    EXPECT_LE(std::abs(got_m - z), 0.52 * step_m + 0.001);
    const double disparity_px = scale / got_m;
    const double steps = disparity_px / config.subpixel_px;
    const double rounding = scale / (got_m * got_m) * 0.0005 / config.subpixel_px;
    EXPECT_NEAR(steps, std::round(steps), rounding + 1e-6);
  }
}

TEST(DepthNoise, OutOfRangeIsNotMeasured) {
  const DepthNoiseConfig config;
  EXPECT_EQ(cv::countNonZero(measure(makePlane(0.2), config)), 0);
  EXPECT_EQ(cv::countNonZero(measure(makePlane(6.5), config)), 0);
  EXPECT_EQ(cv::countNonZero(measure(makePlane(0.0), config)), 0);
}

TEST(DepthNoise, PixelsAtDepthEdgesDropOutAtTheAskedShare) {
  cv::Mat depth = makePlane(2.0);
  for (int u = 0; u < depth.cols; u += 20) depth.colRange(u, u + 10).setTo(1.0);
  DepthNoiseConfig config;
  config.edge_dropout = 0.6;
  const cv::Mat measured = measure(depth, config);
  int edge_missing = 0;
  int edge = 0;
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const bool is_edge = u > 0 && u + 1 < depth.cols && (u % 10 == 0 || u % 10 == 9);
      const bool missing = measured.at<std::uint16_t>(v, u) == 0;
      if (is_edge) {
        ++edge;
        edge_missing += missing ? 1 : 0;
      } else {
        ASSERT_FALSE(missing) << u << " " << v;
      }
    }
  }
  EXPECT_NEAR(edge_missing / static_cast<double>(edge), 0.6, 0.03);
}

/// A floor seen from height h by a level camera: z = h fy / (v - cy) below the horizon. The cosine
/// between ray and normal is h over the length of the ray.
TEST(DepthNoise, GrazingSurfacesDropOutInProportionToTheirCosine) {
  DepthNoiseConfig config;
  config.max_range_m = 60.0;
  config.grazing_cosine = 0.4;
  cv::Mat depth = makePlane(0.0);
  const double height_m = 1.0;
  for (int v = 80; v < depth.rows; ++v) {
    depth.row(v).setTo(height_m * kCamera.fy_px / (v - kCamera.cy_px));
  }
  int frames = 200;
  for (const int v : {95, 120}) {
    const double z = height_m * kCamera.fy_px / (v - kCamera.cy_px);
    const double cosine = height_m / kCamera.unproject(99.5, v, z).norm();
    int missing = 0;
    for (int frame = 0; frame < frames; ++frame) {
      const cv::Mat measured = measure(depth, config, frame);
      for (int u = 98; u < 102; ++u) missing += measured.at<std::uint16_t>(v, u) == 0 ? 1 : 0;
    }
    EXPECT_NEAR(missing / (4.0 * frames), std::max(0.0, 1.0 - cosine / 0.4), 0.08) << v;
  }
}

TEST(DepthNoise, FollowsFromSeedAndFrameNotFromThreads) {
  const DepthNoiseConfig config;
  const cv::Mat a = measure(makePlane(2.0), config, 3, 1);
  const cv::Mat b = measure(makePlane(2.0), config, 3, 4);
  const cv::Mat c = measure(makePlane(2.0), config, 4, 1);
  EXPECT_EQ(std::memcmp(a.data, b.data, a.total() * 2), 0);
  EXPECT_NE(std::memcmp(a.data, c.data, a.total() * 2), 0);
}

TEST(DepthNoise, RefusesOtherImagesAndBadParameters) {
  EXPECT_THROW(measure(cv::Mat(10, 10, CV_16UC1), DepthNoiseConfig{}), std::invalid_argument);
  DepthNoiseConfig config;
  config.edge_dropout = 1.5;
  EXPECT_THROW(measure(makePlane(1.0), config), config::ConfigError);
}

TEST(DepthNoise, WithoutNoiseMillimetresAreRounded) {
  const cv::Mat measured = toMillimetres(makePlane(1.2344), 0.3, 6.0);
  EXPECT_EQ(measured.at<std::uint16_t>(0, 0), 1234);
  EXPECT_EQ(cv::countNonZero(toMillimetres(makePlane(7.0), 0.3, 6.0)), 0);
}

}  // namespace
}  // namespace tsg::simulation
