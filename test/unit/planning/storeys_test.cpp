// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/planning/storeys.h"

#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <sstream>

#include "plan_world.h"
#include "support.h"

namespace tsg::planning {
namespace {

using places::GroundPlan;
using places::PlanCell;
using test::PlanLevel;

/// A ground floor with stairs to a floor at 2.5 m.
std::vector<PlanLevel> makeHouse() {
  std::vector<PlanLevel> levels(2);
  levels[0].addFloor({{0, 0}, {3, 4}}).addFloor({{3, 0}, {8, 2}}, 0.0, 0.5);
  levels[0].addFloor({{3, 2.2}, {12, 4}}).addObstacle({{1, 1}, {2, 2}});
  levels[1].addFloor({{8, 0}, {12, 4}}, 2.5).addObstacle({{10, 2}, {11, 3}});
  return levels;
}

std::int8_t findValue(const StoreyGrid& grid, double x_m, double y_m) {
  return grid.at(GroundPlan(0.1).computeCell({x_m, y_m}));
}

/// The same grids, as a subscriber has them who applies each change.
void applyChanges(const StoreyMap& map, const std::vector<StoreyChange>& changes,
                  std::vector<StoreyGrid>& grids) {
  grids.resize(map.storeys().size());
  for (const StoreyChange& change : changes) {
    const StoreyGrid& now = map.storeys()[change.storey];
    StoreyGrid& grid = grids[change.storey];
    if (change.is_whole) {
      grid = now;
      continue;
    }
    for (int y = 0; y < change.height; ++y) {
      for (int x = 0; x < change.width; ++x) {
        const GroundPlan::Index cell{change.min.first + x, change.min.second + y};
        grid.cells[static_cast<std::size_t>(cell.first - grid.min.first +
                                            grid.width * (cell.second - grid.min.second))] =
            now.at(cell);
      }
    }
  }
}

TEST(StoreyMap, EachStoreyIsAGridAndStairsBelongToTheNearer) {
  StoreyMap map;
  map.update(test::drawPlan(makeHouse()));
  ASSERT_EQ(map.storeys().size(), 2U);
  const StoreyGrid& ground = map.storeys()[0];
  const StoreyGrid& upper = map.storeys()[1];
  EXPECT_NEAR(ground.floor_m, 0.05, 0.06);
  EXPECT_NEAR(upper.floor_m, 2.5, 0.1);
  EXPECT_EQ(findValue(ground, 0.5, 0.5), StoreyGrid::kFree);
  EXPECT_EQ(findValue(ground, 1.5, 1.5), StoreyGrid::kOccupied);
  EXPECT_EQ(findValue(ground, 10.5, 1.0), StoreyGrid::kUnknown);
  EXPECT_EQ(findValue(ground, 10.5, 2.5), StoreyGrid::kFree);
  EXPECT_EQ(findValue(upper, 10.5, 2.5), StoreyGrid::kOccupied);
  EXPECT_EQ(findValue(upper, 9.0, 0.5), StoreyGrid::kFree);
  EXPECT_EQ(findValue(ground, 4.0, 1.0), StoreyGrid::kFree);
  EXPECT_EQ(findValue(upper, 7.5, 1.0), StoreyGrid::kFree);
  EXPECT_EQ(findValue(ground, 7.5, 1.0), StoreyGrid::kUnknown);
}

TEST(StoreyMap, ASmallPlatformIsNoStorey) {
  std::vector<PlanLevel> levels(2);
  levels[0].addFloor({{0, 0}, {6, 6}});
  levels[1].addFloor({{7, 0}, {8.5, 2}}, 2.5);
  StoreyMap map;
  map.update(test::drawPlan(levels));
  EXPECT_EQ(map.storeys().size(), 1U);
}

TEST(StoreyMap, ChangesLeadToTheSameGridsAsDrawingAll) {
  std::mt19937 random(5);
  const GroundPlan whole = test::drawPlan(makeHouse());
  GroundPlan plan(0.1);
  StoreyMap map;
  std::vector<StoreyGrid> followed;
  std::vector<std::pair<GroundPlan::Index, std::vector<GroundPlan::TilePtr>>> tiles(
      whole.tiles().begin(), whole.tiles().end());
  std::size_t parts = 0;
  for (int round = 0; round < 60; ++round) {
    for (int i = 0; i < 6; ++i) {
      const auto& [index, floors] = tiles[random() % tiles.size()];
      plan.setTiles(index, random() % 4 == 0 ? std::vector<GroundPlan::TilePtr>{} : floors);
    }
    const auto changes = map.update(plan);
    for (const auto& change : changes) parts += change.is_whole ? 0 : 1;
    applyChanges(map, changes, followed);
    for (std::size_t storey = 0; storey < map.storeys().size(); ++storey) {
      const StoreyGrid& grid = map.storeys()[storey];
      ASSERT_EQ(followed[storey].cells, grid.cells);
      for (int i = 0; i < grid.width * grid.height; ++i) {
        const GroundPlan::Index cell{grid.min.first + i % grid.width,
                                     grid.min.second + i / grid.width};
        const auto value = grid.cells[static_cast<std::size_t>(i)];
        if (value == StoreyGrid::kUnknown) continue;
        const PlanCell* at = plan.find(cell, grid.floor_m, 3.0);
        ASSERT_NE(at, nullptr);
        EXPECT_EQ(at->isFree(), value == StoreyGrid::kFree);
      }
    }
  }
  EXPECT_GT(parts, 10U);
  EXPECT_TRUE(map.update(plan).empty());
}

TEST(StoreyMap, ATileFarAwayDoesNotBlowUpTheGrid) {
  GroundPlan plan = test::drawPlan(makeHouse());
  auto far = std::make_shared<GroundPlan::Tile>();
  far->fill({PlanCell::State::kFree, 0.0F, 1.0F});
  plan.setTiles({6000, -7000}, {far});
  StoreyMap map;
  map.update(plan);
  for (const StoreyGrid& grid : map.storeys()) EXPECT_LT(grid.cells.size(), 100000U);
  EXPECT_EQ(findValue(map.storeys()[0], 0.5, 0.5), StoreyGrid::kFree);
}

TEST(StoreyFiles, AreThoseOfMapServer) {
  test::TemporaryFolder folder;
  StoreyGrid grid{0.0, 0.5, {-2, 3}, 2, 2, {0, 100, -1, 0}};
  const auto files = writeStoreyFiles(folder.path(), {grid, StoreyGrid{}});
  ASSERT_EQ(files.size(), 2U);
  std::ifstream pgm(folder.path() / "floor_0.pgm", std::ios::binary);
  std::stringstream bytes;
  bytes << pgm.rdbuf();
  // The upper row first.
  EXPECT_EQ(bytes.str(), std::string("P5\n2 2\n255\n") + '\xCD' + '\xFE' + '\xFE' + '\0');
  std::ifstream yaml(folder.path() / "floor_0.yaml");
  std::stringstream text;
  text << yaml.rdbuf();
  EXPECT_NE(text.str().find("image: floor_0.pgm\nresolution: 0.5\norigin: [-1, 1.5, 0.0]\n"),
            std::string::npos)
      << text.str();
}

}  // namespace
}  // namespace tsg::planning
