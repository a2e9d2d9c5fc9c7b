// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/tracking/voxel_set.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <tuple>

#include "reference_tracker.h"

namespace tsg::tracking {
namespace {

using test::computeIoUBySets;
using test::computeVoxelsSlowly;
using test::Voxel;

VoxelSet toVoxelSet(const std::set<Voxel>& voxels) {
  VoxelSet set;
  for (const auto& [x, y, z] : voxels) {
    set.keys.push_back(packVoxel(x, y, z));
    set.box.extend(Eigen::Vector3i(x, y, z));
  }
  std::sort(set.keys.begin(), set.keys.end());
  return set;
}

std::set<Voxel> makeRandomBlob(std::mt19937& random) {
  std::uniform_int_distribution<int> corner(-3, 3);
  std::uniform_int_distribution<int> offset(0, 3);
  std::uniform_int_distribution<int> count(0, 30);
  const Voxel at{corner(random), corner(random), corner(random)};
  std::set<Voxel> voxels;
  for (int i = count(random); i > 0; --i) {
    voxels.insert({std::get<0>(at) + offset(random), std::get<1>(at) + offset(random),
                   std::get<2>(at) + offset(random)});
  }
  return voxels;
}

TEST(VoxelSet, IoUEqualsThatOfPlainSets) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 500; ++trial) {
    const auto a = makeRandomBlob(random);
    const auto b = makeRandomBlob(random);
    ASSERT_EQ(computeIoU(toVoxelSet(a), toVoxelSet(b)), computeIoUBySets(a, b)) << trial;
  }
}

TEST(VoxelSet, PrefilterNeverRejectsAPairThatReachesTheIoU) {
  std::mt19937 random(11);
  int rejected = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const auto a = toVoxelSet(makeRandomBlob(random));
    const auto b = toVoxelSet(makeRandomBlob(random));
    const double iou = computeIoU(a, b);
    const double min_iou = trial % 2 == 0 ? iou : 0.3;
    if (mayReachIoU(a, b, min_iou)) continue;
    ++rejected;
    ASSERT_TRUE(iou == 0.0 || iou < min_iou) << trial;
  }
  EXPECT_GT(rejected, 100);
}

TEST(VoxelSet, PackedKeysAreDistinctOverTheWholeGrid) {
  const int limit = kVoxelLimit - 1;
  std::set<VoxelKey> keys;
  for (const int x : {-limit - 1, -1, 0, 1, limit}) {
    for (const int y : {-limit - 1, -1, 0, 1, limit}) {
      for (const int z : {-limit - 1, -1, 0, 1, limit}) keys.insert(packVoxel(x, y, z));
    }
  }
  EXPECT_EQ(keys.size(), 125U);
}

TEST(SegmentPoints, EqualThoseOfASlowConversion) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> depth_mm(0, 6000);
  std::uniform_int_distribution<int> label(0, 4);
  RgbdFrame frame;
  frame.camera = {40, 30, 35.0, 36.0, 19.5, 14.5};
  frame.T_world_camera = Eigen::Translation3d(1.0, -2.0, 0.5) *
                         Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized());
  frame.depth.image = cv::Mat(30, 40, CV_16UC1);
  cv::Mat labels(30, 40, CV_16UC1);
  for (int i = 0; i < 1200; ++i) {
    frame.depth.image.ptr<std::uint16_t>()[i] = static_cast<std::uint16_t>(depth_mm(random));
    labels.ptr<std::uint16_t>()[i] = static_cast<std::uint16_t>(label(random));
  }
  const PixelFilter filter{0.25, 4.0};
  const auto segments = computeSegmentPoints(frame, labels, 4, filter);
  const auto expected = computeVoxelsSlowly(frame, labels, 4, filter);
  for (std::size_t s = 0; s < 4; ++s) {
    const VoxelSet expected_set = toVoxelSet(expected[s]);
    EXPECT_EQ(segments[s].voxels.keys, expected_set.keys);
    EXPECT_TRUE(segments[s].voxels.box.isApprox(expected_set.box));
    EXPECT_GT(segments[s].pixels, 0U);
  }
}

}  // namespace
}  // namespace tsg::tracking
