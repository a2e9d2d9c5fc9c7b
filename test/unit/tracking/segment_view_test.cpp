// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/tracking/segment_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace tsg::tracking {
namespace {

constexpr double kVoxel_m = 0.1;

/// The voxels of a square of side 2 m around `center_m` with this unit normal.
VoxelSet makeSquare(const Eigen::Vector3d& center_m, const Eigen::Vector3d& normal) {
  const Eigen::Vector3d along = normal.unitOrthogonal();
  const Eigen::Vector3d across = normal.cross(along);
  VoxelSet set;
  for (double a = -1.0; a <= 1.0; a += 0.02) {
    for (double b = -1.0; b <= 1.0; b += 0.02) {
      const Eigen::Vector3i voxel =
          ((center_m + a * along + b * across) / kVoxel_m).array().floor().cast<int>().matrix();
      set.keys.push_back(packVoxel(voxel.x(), voxel.y(), voxel.z()));
      set.box.extend(voxel);
    }
  }
  std::sort(set.keys.begin(), set.keys.end());
  set.keys.erase(std::unique(set.keys.begin(), set.keys.end()), set.keys.end());
  return set;
}

TEST(SegmentView, KnowsDistanceDirectionAndFrontalityOfAPlane) {
  std::mt19937 random(1);
  std::normal_distribution<double> any;
  for (int round = 0; round < 30; ++round) {
    const Eigen::Vector3d center_m(5.0 * any(random), 5.0 * any(random), any(random));
    const Eigen::Vector3d normal =
        Eigen::Vector3d(any(random), any(random), any(random)).normalized();
    const Eigen::Vector3d camera_m =
        center_m + 3.0 * Eigen::Vector3d(any(random), any(random), any(random)).normalized();
    const SegmentView view = computeSegmentView(makeSquare(center_m, normal), kVoxel_m, camera_m);
    EXPECT_NEAR(view.distance_m, 3.0, 0.1);
    EXPECT_GT(view.direction.dot((center_m - camera_m) / 3.0), 0.998);
    EXPECT_NEAR(view.frontality, std::abs(normal.dot(center_m - camera_m)) / 3.0, 0.1);
  }
}

TEST(SegmentView, OfOneVoxelIsHeadOn) {
  VoxelSet set;
  set.keys = {packVoxel(10, 0, 0)};
  set.box.extend(Eigen::Vector3i(10, 0, 0));
  const SegmentView view = computeSegmentView(set, kVoxel_m, {0.0, 0.05, 0.05});
  EXPECT_NEAR(view.distance_m, 1.05, 1e-12);
  EXPECT_TRUE(view.direction.isApprox(Eigen::Vector3d::UnitX(), 1e-12));
  EXPECT_EQ(view.frontality, 1.0);
}

TEST(ViewRecorder, KeepsTheBestViewAndTheSpread) {
  ViewRecorder recorder;
  const auto look = [](double angle_rad, double distance_m) {
    return SegmentView{distance_m, {std::cos(angle_rad), std::sin(angle_rad), 0.0}, 1.0};
  };
  recorder.add({Stamp{1}, 4}, look(0.0, 2.0), 100, false);
  recorder.add({Stamp{2}, 5}, look(0.5, 1.0), 300, false);
  recorder.add({Stamp{3}, 6}, look(-0.7, 3.0), 500, true);  // cut: counts 250
  recorder.add({Stamp{4}, 7}, look(0.1, 4.0), 300, false);  // not more than the best
  const ViewStatistics& views = recorder.statistics();
  EXPECT_EQ(views.best.stamp, Stamp{2});
  EXPECT_EQ(views.best.segment, 5);
  EXPECT_EQ(views.best_pixels, 300U);
  EXPECT_DOUBLE_EQ(views.mean_distance_m, 2.5);
  EXPECT_DOUBLE_EQ(views.min_distance_m, 1.0);
  EXPECT_NEAR(views.spread_rad, 0.7, 1e-12);
}

TEST(CutSegments, AreThoseAtTheBorder) {
  cv::Mat labels = cv::Mat::zeros(10, 20, CV_16UC1);
  labels(cv::Rect(1, 1, 18, 8)).setTo(1);
  labels.at<std::uint16_t>(0, 7) = 2;
  labels.at<std::uint16_t>(9, 7) = 3;
  labels.at<std::uint16_t>(4, 0) = 4;
  labels.at<std::uint16_t>(4, 19) = 5;
  labels.at<std::uint16_t>(5, 19) = 9;  // beyond the number of segments
  EXPECT_EQ(findCutSegments(labels, 6), (std::vector<bool>{false, true, true, true, true, false}));
}

}  // namespace
}  // namespace tsg::tracking
