// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/loops/local_cloud.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace tsg::loops {
namespace {

TEST(LocalCloud, OfOneCellIsTheMeanOfItsPoints) {
  const Points points = {{0.01F, 0.02F, 0.03F}, {-0.5F, 0.0F, 0.0F}, {0.03F, 0.04F, 0.05F}};
  const Points result = downsample(points, 0.1F);
  ASSERT_EQ(result.size(), 2U);
  EXPECT_TRUE(result[0].isApprox(Eigen::Vector3f(0.02F, 0.03F, 0.04F), 1e-5F));
  EXPECT_EQ(result[1], points[1]);
  EXPECT_THROW(downsample(points, 0.0F), std::invalid_argument);
}

TEST(LocalCloud, OfAWallLiesOnItAndLeavesOutWhatIsFarInvalidOrAtAnEdge) {
  const CameraModel camera{40, 30, 40.0, 40.0, 20.0, 15.0};
  DepthImage depth;
  depth.image = cv::Mat(30, 40, CV_16UC1, cv::Scalar(2000));
  depth.image.colRange(0, 10).setTo(0);
  depth.image.colRange(30, 40).setTo(7000);
  const Points points = makeCloud(depth, camera, 0.05F, 5.0F);
  ASSERT_GT(points.size(), 200U);
  for (const Eigen::Vector3f& p : points) {
    EXPECT_NEAR(p.z(), 2.0F, 1e-5F);
    EXPECT_GE(p.x(), (10.0F - 20.0F) / 40.0F * 2.0F - 1e-5F);
    EXPECT_LE(p.x(), (28.0F - 20.0F) / 40.0F * 2.0F + 1e-5F);  // column 29 is at the edge
  }
}

TEST(LocalCloud, IsMovedByThePoseThatMapsItsFrameToTheOther) {
  Pose T = Pose::Identity();
  T.translation() = Eigen::Vector3d(1.0, 2.0, 3.0);
  T.linear() = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()).matrix();
  const Points moved = transform(T, {{1.0F, 0.0F, 0.0F}});
  EXPECT_TRUE(moved[0].isApprox((T * Eigen::Vector3d::UnitX()).cast<float>(), 1e-6F));
}

}  // namespace
}  // namespace tsg::loops
