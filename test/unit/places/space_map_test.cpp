// SPDX-License-Identifier: BSD-3-Clause
#include "places/space_map.h"

#include <gtest/gtest.h>

#include <random>

#include "box_world.h"
#include "layers.h"
#include "sparse_config.h"

namespace tsg::places {
namespace {

using test::BoxWorld;
using test::kVoxel_m;
using test::SeenWorld;

const Aabb kView = makeAabb({-1, -1, -0.5}, {8, 8, 2.2});

void forEachFree(const SeenWorld& seen,
                 const std::function<void(const SpaceCell&, const Eigen::Vector3d&)>& visit) {
  test::forEachFree(seen.layers.space(), seen.voxels.columnIndices(), visit);
}

TEST(WalkableSpace, ClearanceIsTheDistanceToWhatStandsThere) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> shift_m(0.0, 0.1);
  for (int trial = 0; trial < 8; ++trial) {
    const double x0 = shift_m(random);
    const double y0 = shift_m(random);
    BoxWorld world;
    world.addRoom(x0, y0, x0 + 3.03, y0 + 4.06).add({1, 2, 0}, {1.5, 2.5, 1.2});
    int num_free = 0;
    double sum_of_errors_m = 0.0;
    forEachFree(SeenWorld(world, kView), [&](const SpaceCell& cell, const Eigen::Vector3d& p) {
      ++num_free;
      const double expected_m = std::min(3.0, world.computeHorizontalDistance(p, 0.6));
      const double error_m = std::abs(static_cast<double>(cell.clearance_m) - expected_m);
      EXPECT_LT(error_m, kVoxel_m) << p.transpose();
      sum_of_errors_m += error_m;
    });
    EXPECT_LT(sum_of_errors_m / num_free, 0.1 * kVoxel_m);
    EXPECT_GT(num_free, 1000);
  }
}

TEST(WalkableSpace, LowThingsAndLintelsAreNoObstacles) {
  BoxWorld world;
  world.addRoom(0, 0, 5, 5).add({2, 2, 0}, {3, 3, 0.15}).add({0, 2.4, 2.0}, {5, 2.6, 2.5});
  const SeenWorld seen(world, kView);
  const SpaceCell* middle = seen.layers.space().findFree({25, 25}, 0.15, 0.1);
  ASSERT_NE(middle, nullptr);
  EXPECT_NEAR(middle->clearance_m, 2.5, 0.1);
}

TEST(WalkableSpace, OneVoxelOfWallIsAWall) {
  BoxWorld world;
  world.addRoom(0, 0, 6, 4).add({3.0, 0, 0}, {3.1, 4, 2.5});
  const SeenWorld seen(world, kView);
  EXPECT_EQ(test::findParts(seen.extractor.graph()).size(), 2U);
  const SpaceCell* beside = seen.layers.space().findFree({25, 20}, 0.0, 0.1);
  ASSERT_NE(beside, nullptr);
  EXPECT_NEAR(beside->clearance_m, 0.45, 0.06);
}

TEST(VolumeSpace, ClearanceIsTheThreeDimensionalDistance) {
  BoxWorld world;
  world.addRoom(0, 0, 3, 3).add({-0.2, -0.2, 2.0}, {3.2, 3.2, 2.2});
  PlacesConfig config = makeSparseConfig();
  config.free_space = FreeSpaceKind::kVolume;
  int num_free = 0;
  forEachFree(SeenWorld(world, kView, config), [&](const SpaceCell& cell, const auto& p) {
    if (p.minCoeff() < 0.0 || p.maxCoeff() > 3.0 || p.z() > 2.0) return;
    ++num_free;
    EXPECT_NEAR(cell.clearance_m, world.computeDistance(p), 0.5 * kVoxel_m);
  });
  EXPECT_EQ(num_free, 30 * 30 * 20);
}

TEST(Voronoi, OfACorridorIsItsMiddleLine) {
  BoxWorld world;
  world.addRoom(0, 0, 7, 1.4);
  std::map<int, int> num_cells;
  forEachFree(SeenWorld(world, kView), [&](const SpaceCell& cell, const Eigen::Vector3d& p) {
    if (!cell.is_voronoi || p.x() < 1.0 || p.x() > 6.0) return;
    ++num_cells[static_cast<int>(p.x() / kVoxel_m)];
    EXPECT_NEAR(p.y(), 0.7, 0.1);
  });
  for (int x = 10; x < 60; ++x) {
    EXPECT_GE(num_cells[x], 1) << x;
    EXPECT_LE(num_cells[x], 2) << x;
  }
}

TEST(Voronoi, CellsKeepTheirDistanceFromObstacles) {
  BoxWorld world;
  world.addRoom(0, 0, 6, 5).add({2, 2, 0}, {3, 2.5, 1}).add({4, 1, 0}, {4.3, 4, 2});
  int num_cells = 0;
  forEachFree(SeenWorld(world, kView), [&](const SpaceCell& cell, const auto&) {
    if (!cell.is_voronoi) return;
    ++num_cells;
    EXPECT_GE(static_cast<double>(cell.clearance_m), makeSparseConfig().min_clearance_m);
  });
  EXPECT_GT(num_cells, 50);
}

TEST(FreeLine, EndsAtAWallAndHasTheNarrowestClearanceOtherwise) {
  BoxWorld world;
  world.addRoom(0, 0, 6, 5).add({2.9, 0, 0}, {3.1, 2, 2.5}).add({2.9, 3, 0}, {3.1, 5, 2.5});
  const SeenWorld seen(world, kView);
  const auto follow = [&](const GridIndex& from, const GridIndex& to) {
    return followLine(seen.layers.space(), from, 0.0, to, 0.0);
  };
  EXPECT_FALSE(follow({10, 10, 0}, {50, 10, 0}).is_free);
  EXPECT_TRUE(follow({10, 25, 0}, {50, 25, 0}).is_free);
  EXPECT_NEAR(follow({10, 25, 0}, {50, 25, 0}).clearance_m, 0.5, 0.1);
}

TEST(SpaceMap, KeepsItsDistanceFromWhereTheFloorGoesDown) {
  // A floor 1 m above another one, 5 m x 8 m; and one that is a single step lower
  for (const double fall_m : {1.0, 0.15}) {
    SCOPED_TRACE(fall_m);
    BoxWorld world;
    world.addFloor(0, 0, 10, 8).add({0, 0, -0.3}, {5, 8, fall_m});
    const SeenWorld seen(world, makeAabb({-1, -1, -0.5}, {11, 9, 3.5}));
    const PlanCell* cell = seen.extractor.plan().find({40, 40}, fall_m, 0.1);
    ASSERT_NE(cell, nullptr);
    EXPECT_TRUE(cell->isFree());
    if (fall_m > 0.4) {
      EXPECT_NEAR(cell->clearance_m, 0.95F, 0.11F);
    } else {
      EXPECT_GT(cell->clearance_m, 3.0F);
    }
  }
}

}  // namespace
}  // namespace tsg::places
