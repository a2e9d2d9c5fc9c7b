// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/bottleneck/reach.h"

#include <gtest/gtest.h>

namespace tsg::bottleneck {
namespace {

TEST(Reach, IsAShareOfTheMiddleSide) {
  const Aabb box = makeAabb({1.0, 2.0, 3.0}, {1.1, 4.0, 4.0});  // sides 0.1, 2 and 1
  const Aabb extended = extendUpAndDown(box, 0.2);
  EXPECT_TRUE(extended.min().isApprox(Eigen::Vector3d(1.0, 2.0, 2.8)));
  EXPECT_TRUE(extended.max().isApprox(Eigen::Vector3d(1.1, 4.0, 4.2)));
}

TEST(Reach, OfZeroAndOfNothingChangesNothing) {
  const Aabb box = makeAabb({1.0, 2.0, 3.0}, {1.1, 4.0, 4.0});
  EXPECT_TRUE(extendUpAndDown(box, 0.0).isApprox(box));
  EXPECT_TRUE(extendUpAndDown(Aabb(), 0.5).isEmpty());
}

TEST(Reach, JoinsLargeThingsAcrossAGapThatPartsSmallOnes) {
  const auto areNeighbours = [](double side_m, const Eigen::Vector3d& direction) {
    const Eigen::Vector3d side = Eigen::Vector3d::Constant(side_m);
    const Eigen::Vector3d corner = (side_m + 0.08) * direction;
    const Aabb a = makeAabb(Eigen::Vector3d::Zero(), side);
    const Aabb b = makeAabb(corner, corner + side);
    return hasOverlap(extendUpAndDown(a, 0.15), extendUpAndDown(b, 0.15));
  };
  EXPECT_TRUE(areNeighbours(0.5, Eigen::Vector3d::UnitZ()));
  EXPECT_FALSE(areNeighbours(0.1, Eigen::Vector3d::UnitZ()));
  EXPECT_FALSE(areNeighbours(0.5, Eigen::Vector3d::UnitX())) << "side by side";
}

}  // namespace
}  // namespace tsg::bottleneck
