// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/block_selector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "synthetic_scene.h"

namespace tsg::mapping {
namespace {

const CameraModel kCamera{80, 60, 65.0, 66.0, 39.5, 29.5};

bool isLess(const GridIndex& a, const GridIndex& b) {
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

std::vector<GridIndex> sorted(std::vector<GridIndex> indices) {
  std::sort(indices.begin(), indices.end(), isLess);
  indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
  return indices;
}

test::Rendering renderRoom(const Pose& pose) {
  const std::vector<test::Solid> scene{
      test::makePlane({0, 0, 0}, {0, 0, 1}, {90, 90, 90}),
      test::makePlane({4, 0, 0}, {-1, 0, 0}, {10, 200, 30}),
      test::makeSphere({2.0, 0.3, 1.0}, 0.4, {200, 0, 0}),
      test::makeBox({Eigen::Vector3d(1.5, -1.2, 0.0), Eigen::Vector3d(1.53, -1.17, 2.0)},
                    {1, 2, 3})};
  return test::render(scene, kCamera, pose);
}

/// Blocks met by steps of a millimetre along the band (or the whole ray) of every pixel.
std::vector<GridIndex> selectByBruteForce(const RgbdFrame& frame,
                                          const BlockSelector::Options& options,
                                          double max_range_m) {
  std::vector<GridIndex> blocks;
  for (int v = 0; v < kCamera.height_px; ++v) {
    for (int u = 0; u < kCamera.width_px; ++u) {
      const double z_m = frame.depth.at(u, v);
      if (z_m < options.min_range_m || z_m > max_range_m) continue;
      const double begin_m = options.carve_free_space ? options.min_range_m
                                                      : std::max(0.0, z_m - options.truncation_m);
      for (double t_m = begin_m; t_m <= z_m + options.truncation_m; t_m += 0.001) {
        const Eigen::Vector3d p = frame.T_world_camera * kCamera.unproject(u, v, t_m);
        const GridIndex block = (p / options.block_size_m).array().floor().cast<int>().matrix();
        if (blocks.empty() || blocks.back() != block) blocks.push_back(block);
      }
    }
  }
  return sorted(blocks);
}

class BlockSelection : public ::testing::TestWithParam<bool> {};

TEST_P(BlockSelection, NamesEveryBlockThatBruteForceFindsAndFewMore) {
  constexpr double kMaxRange_m = 5.0;
  BlockSelector::Options options;
  options.carve_free_space = GetParam();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> offset(-0.3, 0.3);
  BlockSelector selector;
  DepthBuffer depth;
  for (int i = 0; i < 4; ++i) {
    const Pose pose = test::lookAt({offset(random), offset(random), 1.4 + offset(random)},
                                   {2.0, offset(random), 0.8 + offset(random)});
    const auto frame = renderRoom(pose).frame;
    depth.assign(frame.depth, options.min_range_m, kMaxRange_m,
                 BlockSelector::computeTileSide(kCamera, options.block_size_m, kMaxRange_m));
    const auto selected = sorted(selector.select(depth, kCamera, pose, options));
    const auto expected = selectByBruteForce(frame, options, kMaxRange_m);
    EXPECT_TRUE(
        std::includes(selected.begin(), selected.end(), expected.begin(), expected.end(), isLess));
    EXPECT_LE(selected.size(), 2 * expected.size());
  }
}

INSTANTIATE_TEST_SUITE_P(BandAndCarving, BlockSelection, ::testing::Values(false, true));

TEST(BlockSelector, FindsTheSameBlocksFarFromTheOrigin) {
  const Pose near = test::lookAt({0.05, 0.1, 1.4}, {2.0, 0.1, 0.9});
  Pose far = near;
  const GridIndex shift(250000, -125000, 5000);
  BlockSelector::Options options;
  far.translation() += shift.cast<double>() * options.block_size_m;
  DepthBuffer depth;
  depth.assign(renderRoom(near).frame.depth, 0.3, 5.0, 4);
  BlockSelector selector;
  const auto near_blocks = sorted(selector.select(depth, kCamera, near, options));
  auto far_blocks = selector.select(depth, kCamera, far, options);
  for (auto& block : far_blocks) block -= shift;
  EXPECT_EQ(near_blocks, sorted(far_blocks));
}

TEST(GridIndexSet, HoldsEveryIndexOnceInOrderOfInsertion) {
  GridIndexSet set;
  std::mt19937 random(3);
  std::uniform_int_distribution<int> coordinate(-12, 12);
  std::vector<GridIndex> expected;
  for (int i = 0; i < 20000; ++i) {
    const GridIndex index(coordinate(random), coordinate(random), coordinate(random));
    const bool is_new = std::find(expected.begin(), expected.end(), index) == expected.end();
    ASSERT_EQ(set.insert(index), is_new);
    if (is_new) expected.push_back(index);
  }
  EXPECT_EQ(set.indices(), expected);
  set.clear();
  EXPECT_TRUE(set.insert(expected.front()));
}

class DepthReading : public ::testing::TestWithParam<int> {};

TEST_P(DepthReading, TilesKnowTheLimitsOfTheirValidPixels) {
  std::mt19937 random(11);
  std::uniform_int_distribution<int> millimetres(0, 7000);
  DepthImage image{cv::Mat(23, 37, GetParam()), 0.001, nullptr};
  for (int v = 0; v < 23; ++v) {
    for (int u = 0; u < 37; ++u) {
      const int raw = millimetres(random);
      if (GetParam() == CV_16UC1) {
        image.image.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(raw < 200 ? 65535 : raw);
      } else {
        image.image.at<float>(v, u) = raw < 200 ? std::nanf("") : static_cast<float>(raw);
      }
    }
  }
  DepthBuffer depth;
  depth.assign(image, 0.5, 5.0, 7);
  ASSERT_EQ(depth.tileColumns(), 6);
  ASSERT_EQ(depth.tileRows(), 4);
  EXPECT_EQ(depth.data()[23 * 37], 0.0F);
  for (int row = 0; row < depth.tileRows(); ++row) {
    for (int column = 0; column < depth.tileColumns(); ++column) {
      float min_m = 1e9F;
      float max_m = 0.0F;
      for (int v = 7 * row; v < std::min(7 * row + 7, 23); ++v) {
        for (int u = 7 * column; u < std::min(7 * column + 7, 37); ++u) {
          const float z_m = image.at(u, v);
          const bool valid = z_m >= 0.5F && z_m <= 5.0F;
          EXPECT_FLOAT_EQ(depth.at(u, v), valid ? z_m : 0.0F);
          if (valid) min_m = std::min(min_m, z_m);
          if (valid) max_m = std::max(max_m, z_m);
        }
      }
      EXPECT_FLOAT_EQ(depth.tileMin(column, row), min_m);
      EXPECT_FLOAT_EQ(depth.tileMax(column, row), max_m);
      EXPECT_EQ(depth.computeLimits(7 * column, 7 * row, 7).min_m, depth.tileMin(column, row));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(BothTypes, DepthReading, ::testing::Values(CV_16UC1, CV_32FC1));

TEST(DepthReading, LargestReadingIsInvalidWhateverTheRange) {
  DepthImage image{cv::Mat(4, 4, CV_16UC1, cv::Scalar(65535)), 0.001, nullptr};
  DepthBuffer depth;
  depth.assign(image, 0.0, 100.0, 2);
  EXPECT_FALSE(depth.hasValidDepth());
}

}  // namespace
}  // namespace tsg::mapping
