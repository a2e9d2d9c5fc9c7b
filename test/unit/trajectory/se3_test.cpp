// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/trajectory/se3.h"

#include <gtest/gtest.h>

#include <limits>

#include "graph_worlds.h"

namespace tsg::trajectory {
namespace {

TEST(Se3, AVectorHoldsTranslationAndAngleOfSmallMotions) {
  const Vector6d vector = toVector(makePose(1.0, -2.0, 3.0, 1e-4, {0.0, 1.0, 0.0}));
  EXPECT_TRUE(vector.head<3>().isApprox(Eigen::Vector3d(1.0, -2.0, 3.0)));
  EXPECT_NEAR(vector(4), 1e-4, 1e-12);
  EXPECT_NEAR(vector.tail<3>().norm(), 1e-4, 1e-12);
}

TEST(Se3, TurnsBeyondHalfATurnAreTheShorterOnesTheOtherWay) {
  for (const double angle_rad : {0.5, 2.0, 3.0, 3.5, 5.0, 6.0}) {
    const double shorter_rad = std::remainder(angle_rad, 2.0 * kPi);
    EXPECT_NEAR(toVector(makePose(0.0, 0.0, 0.0, angle_rad))(5), 2.0 * std::sin(shorter_rad / 2.0),
                1e-12)
        << angle_rad;
  }
}

TEST(Se3, TheAdjointBringsSmallMotionsToTheOtherSide) {
  Noise noise(1);
  for (int i = 0; i < 50; ++i) {
    const Pose T = noise.draw(2.0, 1.0);
    const Pose small = noise.draw(1e-6, 1e-6);
    const Vector6d expected = toVector(T * small * T.inverse());
    EXPECT_LT((computeAdjoint(T) * toVector(small) - expected).norm(), 1e-10);
  }
}

TEST(Se3, OnlyFiniteRotationsAreRigid) {
  EXPECT_TRUE(isRigid(makePose(1e6, 0.0, -3.0, 2.0, {1.0, 2.0, 3.0})));
  Pose pose = makePose(0.0, std::numeric_limits<double>::quiet_NaN(), 0.0);
  EXPECT_FALSE(isRigid(pose));
  pose = makePose(0.0, 0.0, 0.0);
  pose.linear() *= 1.001;
  EXPECT_FALSE(isRigid(pose));
  pose = makePose(0.0, 0.0, 0.0);
  pose.linear()(2, 2) = -1.0;  // a mirror
  EXPECT_FALSE(isRigid(pose));
}

}  // namespace
}  // namespace tsg::trajectory
