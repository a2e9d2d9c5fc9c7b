// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/goal_scores.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "plan_world.h"

namespace tsg::evaluation {
namespace {

using test::PlanLevel;
using test::PlanRect;

const PlanRect kExtent{{0.0, 0.0}, {10.0, 8.0}};
const Eigen::Vector3d kStart(1.0, 1.0, 0.0);

PlanLevel makeRoom() { return PlanLevel().addRoom(kExtent); }

/// A wall at x = 5 .. 5.2 that is open above `open_y_m`.
PlanLevel makeTwoRooms(double open_y_m) {
  return makeRoom().addObstacle({{5.0, 0.0}, {5.2, open_y_m}});
}

MapWays makeWays(const PlanLevel& level) {
  return {test::drawPlaces({level}, kExtent), test::drawPlan({level}), {}};
}

RotatedBox makeBox(double x_m, double y_m, double side_m = 0.4) {
  return {{x_m, y_m, 0.2}, Eigen::Vector3d::Constant(side_m), Eigen::Matrix3d::Identity()};
}

Estimate makeEstimate(const RotatedBox& box, const Eigen::VectorXd& cosines) {
  return {box, cosines};
}

Eigen::VectorXd only(double cosine) { return Eigen::VectorXd::Constant(1, cosine); }

GoalScores score(const std::vector<RotatedBox>& things, const std::vector<Estimate>& estimates,
                 const PlanLevel& map, const PlanLevel& truth) {
  return computeGoalScores({{"cup", things}}, estimates, makeWays(map),
                           test::drawPlan({truth}, 0.05), kStart);
}

TEST(GoalScores, InATrueMapTheWayIsTheShortest) {
  const PlanLevel level = makeTwoRooms(6.0);
  const GoalScores scores =
      score({makeBox(9.0, 1.0)}, {makeEstimate(makeBox(9.0, 1.0), only(0.3))}, level, level);
  ASSERT_EQ(scores.num_tasks, 1U);
  EXPECT_EQ(scores.success, 1.0);
  EXPECT_EQ(scores.strict, 1.0);
  // Round the wall's end: to (5 - .25, 6), over it, and on to 0.55 m before the box.
  const double least_m =
      test::computeShortestWay(level, kExtent, {1.0, 1.0}, {8.55, 1.6}, 0.25) - 0.7;
  ASSERT_TRUE(scores.rows[0].shortest_m);
  EXPECT_GT(*scores.rows[0].shortest_m, least_m);
  EXPECT_LT(*scores.rows[0].shortest_m, least_m + 1.4);
  EXPECT_NEAR(scores.median_ratio, 1.0, 0.05);
  EXPECT_NEAR(scores.spl, 1.0, 0.05);
}

TEST(GoalScores, StraightWayEndsBeforeTheThing) {
  const GoalScores scores = score({makeBox(8.0, 1.0)}, {makeEstimate(makeBox(8.0, 1.0), only(0.3))},
                                  makeRoom(), makeRoom());
  // Box from 7.8, stand-off 0.3, radius 0.25.
  EXPECT_NEAR(*scores.rows[0].shortest_m, 7.8 - 0.55 - 1.0, 0.1);
  EXPECT_NEAR(scores.rows[0].path_m, 7.8 - 0.55 - 1.0, 0.25);  // cells of 10 cm
}

TEST(GoalScores, AWayRoundWhatIsNotThereIsLonger) {
  const GoalScores scores = score({makeBox(8.0, 1.0)}, {makeEstimate(makeBox(8.0, 1.0), only(0.3))},
                                  makeTwoRooms(6.0), makeRoom());
  EXPECT_EQ(scores.success, 1.0);
  EXPECT_GT(scores.median_ratio, 1.7);
  EXPECT_NEAR(scores.spl, 1.0 / scores.median_ratio, 1e-9);
  EXPECT_EQ(scores.max_ratio, scores.median_ratio);
}

TEST(GoalScores, AWayThroughAWallThatTheMapMissesIsNoSuccess) {
  const GoalScores scores = score({makeBox(8.0, 1.0)}, {makeEstimate(makeBox(8.0, 1.0), only(0.3))},
                                  makeRoom(), makeTwoRooms(6.0));
  EXPECT_EQ(scores.right, 1.0);
  EXPECT_EQ(scores.path, 1.0);
  EXPECT_EQ(scores.free, 0.0);
  EXPECT_EQ(scores.success, 0.0);
  EXPECT_EQ(scores.spl, 0.0);
  EXPECT_EQ(scores.rows[0].least_clearance_m, 0.0);
}

TEST(GoalScores, AWayMayLieHalfAMetreAboveTheTrueFloorAndNotMore) {
  RotatedBox box = makeBox(8.0, 1.0);
  box.center_m.z() = 1.0;
  const auto scoreRise = [&](double rise) {  // the way ends 6.2 m on from the start
    return score({box}, {makeEstimate(box, only(0.3))}, PlanLevel().addFloor(kExtent, -rise, rise),
                 makeRoom());
  };
  EXPECT_EQ(scoreRise(0.07).success, 1.0);
  const GoalScores above = scoreRise(0.1);
  EXPECT_EQ(above.path, 1.0);
  EXPECT_EQ(above.free, 0.0);
}

TEST(GoalScores, TheObjectOfHighestCosineIsGoneTo) {
  const std::vector<Estimate> estimates = {makeEstimate(makeBox(3.0, 5.0), only(0.31)),
                                           makeEstimate(makeBox(8.0, 1.0), only(0.30))};
  const GoalScores wrong = score({makeBox(8.0, 1.0)}, estimates, makeRoom(), makeRoom());
  EXPECT_EQ(wrong.right, 0.0);
  EXPECT_EQ(wrong.path, 1.0);
  EXPECT_EQ(wrong.success, 0.0);
  EXPECT_FALSE(wrong.rows[0].shortest_m);
  const GoalScores right =
      score({makeBox(8.0, 1.0), makeBox(3.0, 5.0)}, estimates, makeRoom(), makeRoom());
  EXPECT_EQ(right.success, 1.0);
  EXPECT_NEAR(right.median_ratio, 1.0, 0.05);  // against the thing that it stands for
}

TEST(GoalScores, ARelaxedMatchIsRightAndNotStrict) {
  const GoalScores scores =
      score({makeBox(8.0, 1.0)}, {makeEstimate(makeBox(8.4, 1.4, 1.2), only(0.3))}, makeRoom(),
            makeRoom());
  EXPECT_EQ(scores.right, 1.0);
  EXPECT_EQ(scores.strict, 0.0);
}

TEST(GoalScores, ThingsThatNobodyCanReachDoNotCount) {
  const PlanLevel closed = makeTwoRooms(8.0);
  const GoalScores scores =
      score({makeBox(8.0, 1.0)}, {makeEstimate(makeBox(8.0, 1.0), only(0.3))}, closed, closed);
  EXPECT_EQ(scores.num_tasks, 0U);
  EXPECT_EQ(scores.num_unreachable, 1U);
  EXPECT_EQ(scores.success, 0.0);
}

TEST(GoalScores, MapWithoutObjectsOrWayFailsEveryTask) {
  const GoalScores empty = score({makeBox(8.0, 1.0)}, {}, makeRoom(), makeRoom());
  EXPECT_EQ(empty.num_tasks, 1U);
  EXPECT_EQ(empty.success, 0.0);
  EXPECT_FALSE(empty.rows[0].has_object);
  const GoalScores closed = score({makeBox(8.0, 1.0)}, {makeEstimate(makeBox(8.0, 1.0), only(0.3))},
                                  makeTwoRooms(8.0), makeRoom());
  EXPECT_EQ(closed.right, 1.0);
  EXPECT_EQ(closed.path, 0.0);
  EXPECT_EQ(closed.success, 0.0);
  EXPECT_NE(closed.rows[0].message, "");
}

TEST(GoalScores, TasksWithoutThingsAreLeftOut) {
  const Eigen::Vector2d cosines(0.3, 0.4);
  const GoalScores scores = computeGoalScores(
      {{"cup", {makeBox(8.0, 1.0)}}, {"parrot", {}}}, {makeEstimate(makeBox(8.0, 1.0), cosines)},
      makeWays(makeRoom()), test::drawPlan({makeRoom()}, 0.05), kStart);
  ASSERT_EQ(scores.rows.size(), 1U);
  EXPECT_EQ(scores.rows[0].task, "cup");
  EXPECT_EQ(scores.success, 1.0);
}

TEST(GoalScores, BadInputIsRefused) {
  const auto floor = test::drawPlan({makeRoom()}, 0.05);
  const std::vector<TaskTruth> truth = {{"cup", {makeBox(8.0, 1.0)}}};
  EXPECT_THROW(computeGoalScores(truth, {makeEstimate(makeBox(8, 1), Eigen::Vector2d(0.3, 0.2))},
                                 makeWays(makeRoom()), floor, kStart),
               std::invalid_argument);
  const MapWays none;
  EXPECT_THROW(computeGoalScores(truth, {}, none, floor, kStart), std::invalid_argument);
  EXPECT_THROW(computeGoalScores(truth, {}, makeWays(makeRoom()), floor, {30.0, 1.0, 0.0}),
               std::invalid_argument);
}

}  // namespace
}  // namespace tsg::evaluation
