// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/tsdf_integrator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "synthetic_scene.h"
#include "task_scene_graph/config/config.h"

namespace tsg::mapping {
namespace {

const CameraModel kCamera{160, 120, 131.0, 131.5, 79.5, 59.5};

std::vector<test::Solid> makeRoom() {
  return {test::makePlane({0, 0, 0}, {0, 0, 1}, {90, 90, 90}),
          test::makePlane({3.5, 0, 0}, {-1, 0, 0}, {10, 200, 30}),
          test::makeSphere({2.0, 0.2, 0.9}, 0.4, {200, 0, 0})};
}

RgbdFrame makeNoisyFrame(const Pose& pose, unsigned seed) {
  RgbdFrame frame = test::render(makeRoom(), kCamera, pose).frame;
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(0.0F, 0.01F);
  std::uniform_int_distribution<int> percent(0, 99);
  cv::Mat raw(frame.depth.image.size(), CV_16UC1);
  for (int v = 0; v < raw.rows; ++v) {
    for (int u = 0; u < raw.cols; ++u) {
      const float z_m = frame.depth.image.at<float>(v, u) + noise(random);
      const int dice = percent(random);
      raw.at<std::uint16_t>(v, u) = dice == 0   ? 0
                                    : dice == 1 ? 65535
                                                : static_cast<std::uint16_t>(1000.0F * z_m);
      auto& color = frame.color.image.at<cv::Vec3b>(v, u);
      for (int channel = 0; channel < 3; ++channel) {
        color[channel] = static_cast<unsigned char>((color[channel] + percent(random)) % 256);
      }
    }
  }
  frame.depth.image = raw;
  frame.depth.metres_per_unit = 0.001;
  return frame;
}

struct OracleVoxel {
  double distance_m = 0.0;
  double weight = 0.0;
  Eigen::Vector3d color = Eigen::Vector3d::Zero();
  bool has_color = false;
  bool is_borderline = false;  ///< rounding decides which pixel or branch applies
};

bool isNearHalf(double value) { return std::abs(value - std::floor(value) - 0.5) < 1e-3; }

/// The formulas of TsdfIntegrator's documentation, in double precision, for one voxel.
void integrateByFormula(const RgbdFrame& frame, const IntegratorConfig& config,
                        const Eigen::Vector3d& center, OracleVoxel& voxel) {
  const Eigen::Vector3d p = frame.T_world_camera.inverse() * center;
  if (p.z() <= 0.01) return;
  const Eigen::Vector2d pixel = kCamera.project(p);
  voxel.is_borderline |= isNearHalf(pixel.x()) || isNearHalf(pixel.y());
  const auto u = static_cast<int>(std::floor(pixel.x() + 0.5));
  const auto v = static_cast<int>(std::floor(pixel.y() + 0.5));
  if (u < 0 || v < 0 || u >= kCamera.width_px || v >= kCamera.height_px) return;
  const double depth = frame.depth.at(u, v);
  if (depth <= 0.0 || depth < config.min_range_m || depth > config.max_range_m) return;
  const double s = (depth - p.z()) * p.norm() / p.z();
  const double drop_off = config.drop_off_start_voxels * config.voxel_size_m;
  voxel.is_borderline |= std::abs(s + config.truncation_m) < 1e-4 ||
                         std::abs(std::abs(s) - config.truncation_m) < 1e-4;
  if (s <= -config.truncation_m) return;
  double weight =
      kCamera.fx_px * kCamera.fy_px * std::pow(config.voxel_size_m / p.z(), 2) / (p.z() * p.z());
  if (s < -drop_off) weight *= (config.truncation_m + s) / (config.truncation_m - drop_off);
  const double total = voxel.weight + weight;
  const double share = weight / total;
  voxel.distance_m += (std::min(s, config.truncation_m) - voxel.distance_m) * share;
  voxel.weight = std::min(total, config.max_weight);
  if (std::abs(s) >= config.truncation_m) return;
  const auto& rgb = frame.color.image.at<cv::Vec3b>(v, u);
  const Eigen::Vector3d color(rgb[0], rgb[1], rgb[2]);
  voxel.color =
      voxel.has_color ? Eigen::Vector3d(voxel.color + (color - voxel.color) * share) : color;
  voxel.has_color = true;
}

GridIndex voxelOf(const TsdfBlock& block, int i) {
  return block.index * kBlockSide + GridIndex(i & 7, i >> 3 & 7, i >> 6);
}

bool contains(const std::vector<GridIndex>& ascending, const GridIndex& index) {
  return std::binary_search(ascending.begin(), ascending.end(), index, isBefore);
}

bool haveSameBits(const TsdfVolume& a, const TsdfVolume& b) {
  if (a.sortedBlockIndices() != b.sortedBlockIndices()) return false;
  for (const auto& [index, block] : a.blocks()) {
    const TsdfBlock* other = b.findBlock(index);
    if (std::memcmp(&block->voxels, &other->voxels, sizeof(block->voxels)) != 0) return false;
    if (std::memcmp(&block->colors, &other->colors, sizeof(block->colors)) != 0) return false;
  }
  return true;
}

TEST(TsdfIntegrator, FollowsItsFormulasInEveryVoxel) {
  IntegratorConfig config;
  config.max_weight = 90.0;
  TsdfVolume volume(config.voxel_size_m);
  TsdfIntegrator integrator(config);
  const std::vector<RgbdFrame> frames{
      makeNoisyFrame(test::lookAt({0, 0, 1.3}, {2, 0.1, 0.9}), 1),
      makeNoisyFrame(test::lookAt({0.02, 0.03, 1.31}, {2, 0.12, 0.9}), 2)};
  std::vector<std::vector<GridIndex>> observed;
  for (const auto& frame : frames) {
    observed.push_back(integrator.integrate(frame, volume).observed_blocks);
  }
  int compared = 0;
  for (const auto& [index, block] : volume.blocks()) {
    for (int i = 0; i < kBlockVoxels; ++i) {
      OracleVoxel expected;
      for (std::size_t k = 0; k < frames.size(); ++k) {
        if (!contains(observed[k], index)) continue;
        integrateByFormula(frames[k], config, volume.computeVoxelCenter(voxelOf(*block, i)),
                           expected);
      }
      if (expected.is_borderline) continue;
      const auto& voxel = block->voxels[static_cast<std::size_t>(i)];
      ++compared;
      ASSERT_NEAR(voxel.weight, expected.weight, 1e-3 * expected.weight + 1e-4);
      ASSERT_NEAR(voxel.distance_m, expected.distance_m, 2e-5);
      const auto& color = block->colors[static_cast<std::size_t>(i)];
      ASSERT_EQ(color.known != 0, expected.has_color);
      ASSERT_NEAR(color.r, expected.color.x(), 1.5);
      ASSERT_NEAR(color.b, expected.color.z(), 1.5);
    }
  }
  EXPECT_GT(compared, 20000);
}

TEST(TsdfIntegrator, DistancesOfAPlaneAreRightWithinHalfAVoxel) {
  for (const double slope_deg : {0.0, 30.0, 50.0, 70.0}) {
    const double angle = slope_deg * M_PI / 180.0;
    const Eigen::Vector3d normal(-std::cos(angle), 0.0, std::sin(angle));
    const std::vector<test::Solid> scene{test::makePlane({2, 0, 1}, normal, {50, 60, 70})};
    IntegratorConfig config;
    TsdfVolume volume(config.voxel_size_m);
    TsdfIntegrator integrator(config);
    const auto frame = test::render(scene, kCamera, test::lookAt({0, 0, 1}, {2, 0, 1})).frame;
    integrator.integrate(frame, volume);
    double squares = 0.0;
    double sum = 0.0;
    int count = 0;
    for (const auto& [index, block] : volume.blocks()) {
      for (int i = 0; i < kBlockVoxels; ++i) {
        const auto& voxel = block->voxels[static_cast<std::size_t>(i)];
        const Eigen::Vector3d center = volume.computeVoxelCenter(voxelOf(*block, i));
        const double truth = scene[0].distance_m(center);
        if (voxel.weight <= 0.0F || std::abs(truth) > 0.5 * config.voxel_size_m) continue;
        // Along the ray, the distance is that to the plane over the cosine.
        const Eigen::Vector3d ray = (center - Eigen::Vector3d(0, 0, 1)).normalized();
        const double error = voxel.distance_m * std::abs(normal.dot(ray)) - truth;
        squares += error * error;
        sum += error;
        ++count;
      }
    }
    ASSERT_GT(count, 100);
    EXPECT_LE(std::sqrt(squares / count), 0.2 * config.voxel_size_m) << slope_deg;
    EXPECT_LE(std::abs(sum / count), 0.03 * config.voxel_size_m) << slope_deg;
  }
}

TEST(TsdfIntegrator, ThreadCountDoesNotChangeABit) {
  std::vector<TsdfVolume> volumes;
  std::vector<std::vector<GridIndex>> changed;
  for (const int threads : {1, 2, 7}) {
    IntegratorConfig config;
    config.num_threads = threads;
    config.carve_free_space = true;
    volumes.emplace_back(config.voxel_size_m);
    TsdfIntegrator integrator(config);
    integrator.integrate(makeNoisyFrame(test::lookAt({0, 0, 1.3}, {2, 0.1, 0.9}), 1),
                         volumes.back());
    changed.push_back(
        integrator
            .integrate(makeNoisyFrame(test::lookAt({0, 0.2, 1}, {2, 0, 0.5}), 2), volumes.back())
            .changed_blocks);
  }
  for (std::size_t i = 1; i < volumes.size(); ++i) {
    EXPECT_TRUE(haveSameBits(volumes[0], volumes[i]));
    EXPECT_EQ(changed[0], changed[i]);
  }
}

TEST(TsdfIntegrator, FramesWithoutValidDepthChangeNothing) {
  IntegratorConfig config;
  TsdfIntegrator integrator(config);
  TsdfVolume volume(config.voxel_size_m);
  RgbdFrame frame = makeNoisyFrame(test::lookAt({0, 0, 1.3}, {2, 0.1, 0.9}), 1);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<cv::Mat> images{
      cv::Mat(kCamera.height_px, kCamera.width_px, CV_16UC1, cv::Scalar(0)),
      cv::Mat(kCamera.height_px, kCamera.width_px, CV_16UC1, cv::Scalar(65535)),
      cv::Mat(kCamera.height_px, kCamera.width_px, CV_32FC1, cv::Scalar(nan)),
      cv::Mat(kCamera.height_px, kCamera.width_px, CV_32FC1, cv::Scalar(-1.0)),
      cv::Mat(kCamera.height_px, kCamera.width_px, CV_16UC1, cv::Scalar(20000))};
  for (const auto& image : images) {
    frame.depth.image = image;
    const auto result = integrator.integrate(frame, volume);
    EXPECT_EQ(result.status, IntegrationStatus::kNoValidDepth);
    EXPECT_TRUE(result.changed_blocks.empty());
  }
  EXPECT_TRUE(volume.blocks().empty());
}

TEST(TsdfIntegrator, PoseJumpsOnlyMeanOtherBlocks) {
  IntegratorConfig config;
  const RgbdFrame here = makeNoisyFrame(test::lookAt({0, 0, 1.3}, {2, 0.1, 0.9}), 1);
  RgbdFrame there = here;
  there.T_world_camera.translation() += Eigen::Vector3d(80.0, -40.0, 16.0);
  TsdfVolume both(config.voxel_size_m);
  TsdfVolume one(config.voxel_size_m);
  TsdfIntegrator integrator(config);
  integrator.integrate(here, both);
  integrator.integrate(there, both);
  TsdfIntegrator(config).integrate(there, one);
  for (const auto& [index, block] : one.blocks()) {
    const TsdfBlock* same = both.findBlock(index);
    ASSERT_NE(same, nullptr);
    EXPECT_EQ(std::memcmp(&block->voxels, &same->voxels, sizeof(block->voxels)), 0);
  }
  there.T_world_camera.translation().x() = 1e8;
  EXPECT_EQ(integrator.integrate(there, both).status, IntegrationStatus::kPoseOutOfRange);
}

TEST(TsdfIntegrator, ImagesWithGapsBetweenRowsGiveTheSameBits) {
  IntegratorConfig config;
  const RgbdFrame frame = makeNoisyFrame(test::lookAt({0, 0, 1.3}, {2, 0.1, 0.9}), 1);
  RgbdFrame gaps = frame;
  const cv::Rect inner(5, 3, kCamera.width_px, kCamera.height_px);
  cv::Mat color(kCamera.height_px + 9, kCamera.width_px + 8, CV_8UC3);
  cv::Mat depth(kCamera.height_px + 9, kCamera.width_px + 8, CV_16UC1);
  frame.color.image.copyTo(color(inner));
  frame.depth.image.copyTo(depth(inner));
  gaps.color.image = color(inner);
  gaps.depth.image = depth(inner);
  TsdfVolume a(config.voxel_size_m);
  TsdfVolume b(config.voxel_size_m);
  TsdfIntegrator(config).integrate(frame, a);
  TsdfIntegrator(config).integrate(gaps, b);
  EXPECT_TRUE(haveSameBits(a, b));
}

TEST(TsdfIntegrator, ChannelOrderOfTheImageIsRespected) {
  IntegratorConfig config;
  RgbdFrame frame = makeNoisyFrame(test::lookAt({0, 0, 1.3}, {2, 0.1, 0.9}), 1);
  TsdfVolume rgb(config.voxel_size_m);
  TsdfVolume bgr(config.voxel_size_m);
  TsdfIntegrator(config).integrate(frame, rgb);
  cv::Mat swapped(frame.color.image.size(), CV_8UC3);
  for (int v = 0; v < swapped.rows; ++v) {
    for (int u = 0; u < swapped.cols; ++u) {
      const auto& c = frame.color.image.at<cv::Vec3b>(v, u);
      swapped.at<cv::Vec3b>(v, u) = {c[2], c[1], c[0]};
    }
  }
  frame.color = {frame.stamp, swapped, ColorOrder::kBgr, nullptr};
  TsdfIntegrator(config).integrate(frame, bgr);
  EXPECT_TRUE(haveSameBits(rgb, bgr));
}

TEST(TsdfIntegrator, CarvingFreesWhatTheCameraLooksThrough) {
  const Pose pose = test::lookAt({0, 0, 1}, {3, 0, 1});
  const std::vector<test::Solid> wall{test::makePlane({3, 0, 0}, {-1, 0, 0}, {9, 9, 9})};
  auto with_ball = wall;
  with_ball.push_back(test::makeSphere({1.5, 0, 1}, 0.2, {200, 0, 0}));
  for (const bool carve : {false, true}) {
    IntegratorConfig config;
    config.carve_free_space = carve;
    TsdfVolume volume(config.voxel_size_m);
    TsdfIntegrator integrator(config);
    integrator.integrate(test::render(with_ball, kCamera, pose).frame, volume);
    const auto on_ball = volume.computeVoxelIndex({1.33, 0.01, 1.01});
    ASSERT_NE(volume.findVoxel(on_ball), nullptr);
    const float before = volume.findVoxel(on_ball)->distance_m;
    for (int i = 0; i < 30; ++i) {
      integrator.integrate(test::render(wall, kCamera, pose).frame, volume);
    }
    const float after = volume.findVoxel(on_ball)->distance_m;
    EXPECT_LT(before, 0.5F * static_cast<float>(config.voxel_size_m));
    if (carve) {
      EXPECT_GT(after, 0.8F * static_cast<float>(config.truncation_m));
    } else {
      EXPECT_EQ(after, before);
    }
    const TsdfVoxel* in_between = volume.findVoxel(volume.computeVoxelIndex({0.7, 0.1, 1.1}));
    EXPECT_EQ(in_between != nullptr && in_between->weight > 0.0F, carve);
  }
}

TEST(TsdfIntegrator, ReadingsBeyondTheRangeFreeTheSpaceWithinIt) {
  const std::vector<test::Solid> wall{test::makePlane({6, 0, 0}, {-1, 0, 0}, {9, 9, 9})};
  const auto frame = test::render(wall, kCamera, test::lookAt({0, 0, 1}, {3, 0, 1})).frame;
  IntegratorConfig config;
  config.max_range_m = 4.0;
  config.carve_free_space = true;
  TsdfVolume volume(config.voxel_size_m);
  TsdfIntegrator(config).integrate(frame, volume);
  const auto weightAt = [&](double x_m) {
    const TsdfVoxel* voxel = volume.findVoxel(volume.computeVoxelIndex({x_m, 0.1, 1.1}));
    return voxel == nullptr ? 0.0F : voxel->weight;
  };
  EXPECT_GT(weightAt(3.92), 0.0F);
  EXPECT_EQ(weightAt(4.08), 0.0F);
  for (const auto& [index, block] : volume.blocks()) {
    for (const auto& voxel : block->voxels) {
      EXPECT_FLOAT_EQ(voxel.distance_m, voxel.weight > 0.0F ? 0.2F : 0.0F);
    }
  }
}

TEST(TsdfIntegrator, BlocksSeenAsFreeBeforeDoNotCountAsChanged) {
  IntegratorConfig config;
  config.carve_free_space = true;
  const RgbdFrame frame = makeNoisyFrame(test::lookAt({0, 0, 1.3}, {2, 0.1, 0.9}), 1);
  TsdfVolume volume(config.voxel_size_m);
  TsdfIntegrator integrator(config);
  const auto first = integrator.integrate(frame, volume);
  const auto second = integrator.integrate(frame, volume);
  EXPECT_EQ(first.num_new_blocks, volume.blocks().size());
  EXPECT_EQ(second.num_new_blocks, 0U);
  EXPECT_EQ(first.changed_blocks, first.observed_blocks);
  EXPECT_EQ(second.observed_blocks, first.observed_blocks);
  EXPECT_LT(second.changed_blocks.size(), first.changed_blocks.size());
  for (const auto& index : second.observed_blocks) {
    const bool is_changed = contains(second.changed_blocks, index);
    bool has_band = false;
    for (const auto& voxel : volume.findBlock(index)->voxels) {
      has_band |= voxel.weight > 0.0F && voxel.distance_m < config.truncation_m - 1e-6;
    }
    EXPECT_TRUE(!has_band || is_changed);
  }
}

TEST(TsdfIntegrator, ConfigErrorsNameEveryViolation) {
  IntegratorConfig config;
  config.truncation_m = 0.06;
  config.min_range_m = 9.0;
  try {
    TsdfIntegrator integrator(config);
    FAIL() << "nothing was thrown";
  } catch (const config::ConfigError& e) {
    const std::string message = e.what();
    EXPECT_NE(message.find("truncation_m is 0.06"), std::string::npos) << message;
    EXPECT_NE(message.find("min_range_m is 9"), std::string::npos) << message;
  }
}

TEST(TsdfIntegrator, FrameAndVolumeMustFit) {
  IntegratorConfig config;
  TsdfIntegrator integrator(config);
  TsdfVolume other(0.1);
  RgbdFrame frame = makeNoisyFrame(test::lookAt({0, 0, 1.3}, {2, 0.1, 0.9}), 1);
  EXPECT_THROW(integrator.integrate(frame, other), std::invalid_argument);
  TsdfVolume volume(config.voxel_size_m);
  frame.camera.width_px = 80;
  EXPECT_THROW(integrator.integrate(frame, volume), std::invalid_argument);
}

}  // namespace
}  // namespace tsg::mapping
