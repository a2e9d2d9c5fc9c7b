// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/bottleneck/reach.h"

#include <gtest/gtest.h>

namespace tsg::bottleneck {
namespace {

TEST(Reach, IsAShareOfTheMiddleSide) {
  const Aabb box = makeAabb({1.0, 2.0, 3.0}, {1.1, 4.0, 4.0});  // sides 0.1, 2 and 1
  const Aabb extended = extendByReach(box, 0.2);
  EXPECT_TRUE(extended.min().isApprox(Eigen::Vector3d(0.8, 1.8, 2.8)));
  EXPECT_TRUE(extended.max().isApprox(Eigen::Vector3d(1.3, 4.2, 4.2)));
}

TEST(Reach, OfZeroAndOfNothingChangesNothing) {
  const Aabb box = makeAabb({1.0, 2.0, 3.0}, {1.1, 4.0, 4.0});
  EXPECT_TRUE(extendByReach(box, 0.0).isApprox(box));
  EXPECT_TRUE(extendByReach(Aabb(), 0.5).isEmpty());
}

TEST(Reach, JoinsLargeThingsAcrossAGapThatPartsSmallOnes) {
  const auto areNeighbours = [](double side_m) {
    const Eigen::Vector3d side = Eigen::Vector3d::Constant(side_m);
    const Eigen::Vector3d corner(side_m + 0.08, 0.0, 0.0);
    const Aabb a = makeAabb(Eigen::Vector3d::Zero(), side);
    const Aabb b = makeAabb(corner, corner + side);
    return hasOverlap(extendByReach(a, 0.15), extendByReach(b, 0.15));
  };
  EXPECT_TRUE(areNeighbours(0.5));
  EXPECT_FALSE(areNeighbours(0.1));
}

}  // namespace
}  // namespace tsg::bottleneck
