// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/trajectory/trajectory_error.h"

#include <gtest/gtest.h>

#include "graph_worlds.h"

namespace tsg::trajectory {
namespace {

Trajectory makeLine(int num, double step_m, const Pose& T_world_start = Pose::Identity()) {
  Trajectory line;
  for (int i = 0; i < num; ++i) {
    line.add({i * 100000000LL}, T_world_start * makePose(step_m * i, 0.0, 0.0));
  }
  return line;
}

TEST(TrajectoryError, OfAScaledLineIsThatOfASumOfSquares) {
  // 0.1 m more with each of poses 0 to 4: root of (0 + 1 + 4 + 9 + 16) / 5 tenths.
  EXPECT_NEAR(computeTrajectoryError(makeLine(5, 1.0), makeLine(5, 1.1)), 0.1 * std::sqrt(6.0),
              1e-12);
}

TEST(TrajectoryError, DoesNotDependOnWhereTheEstimateBegins) {
  const Pose elsewhere = makePose(3.0, -2.0, 1.0, 0.7, {1.0, 2.0, 3.0});
  EXPECT_NEAR(computeTrajectoryError(makeLine(9, 1.0), makeLine(9, 1.0, elsewhere)), 0.0, 1e-12);
}

TEST(TrajectoryError, WhereThereIsNoTruthIsRejected) {
  EXPECT_THROW(computeTrajectoryError(makeLine(5, 1.0), makeLine(6, 1.0)), std::invalid_argument);
  EXPECT_THROW(computeTrajectoryError({}, makeLine(6, 1.0)), std::invalid_argument);
  EXPECT_THROW(computeTrajectoryError(makeLine(5, 1.0), {}), std::invalid_argument);
}

}  // namespace
}  // namespace tsg::trajectory
