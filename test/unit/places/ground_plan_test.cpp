// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/places/ground_plan.h"

#include <gtest/gtest.h>

namespace tsg::places {
namespace {

GroundPlan::TilePtr makeTile(float floor_m, PlanCell::State state) {
  auto tile = std::make_shared<GroundPlan::Tile>();
  tile->fill({state, floor_m, 1.0F});
  return tile;
}

TEST(GroundPlan, CellsBelowZeroLieInTheTileBeforeTheOrigin) {
  EXPECT_EQ(computeTile({-1, -8}), (GroundPlan::Index{-1, -1}));
  EXPECT_EQ(computeTile({-9, 7}), (GroundPlan::Index{-2, 0}));
  EXPECT_EQ(computeOffset({-1, -8}), 7U);
  EXPECT_EQ(computeOffset({9, 2}), 17U);
}

TEST(GroundPlan, FindsTheFloorNearestInHeight) {
  GroundPlan plan(0.1);
  plan.setTiles(
      {0, 0}, {makeTile(0.0F, PlanCell::State::kFree), makeTile(2.8F, PlanCell::State::kObstacle)});
  ASSERT_NE(plan.find({3, 3}, 0.1, 0.2), nullptr);
  EXPECT_TRUE(plan.find({3, 3}, 0.1, 0.2)->isFree());
  EXPECT_FALSE(plan.find({3, 3}, 2.7, 0.2)->isFree());
  EXPECT_EQ(plan.find({3, 3}, 1.4, 0.2), nullptr);
  EXPECT_EQ(plan.find({8, 3}, 0.0, 0.2), nullptr);
}

TEST(GroundPlan, ACellWithoutAFloorIsNotFound) {
  GroundPlan plan(0.1);
  plan.setTiles({0, 0}, {std::make_shared<GroundPlan::Tile>()});
  EXPECT_EQ(plan.find({0, 0}, 0.0, 100.0), nullptr);
}

TEST(GroundPlan, ACopyKeepsWhatTheOriginalReplaces) {
  GroundPlan plan(0.1);
  plan.setTiles({0, 0}, {makeTile(0.0F, PlanCell::State::kFree)});
  const GroundPlan snapshot = plan;
  plan.setTiles({0, 0}, {});
  EXPECT_EQ(plan.find({0, 0}, 0.0, 0.2), nullptr);
  EXPECT_NE(snapshot.find({0, 0}, 0.0, 0.2), nullptr);
}

TEST(GroundPlan, CellAndCenterAreInverse) {
  const GroundPlan plan(0.1);
  for (int x = -20; x <= 20; ++x) {
    EXPECT_EQ(plan.computeCell(plan.computeCenter({x, 3 * x})), (GroundPlan::Index{x, 3 * x}));
  }
}

}  // namespace
}  // namespace tsg::places
