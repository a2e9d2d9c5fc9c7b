// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/places/free_space.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "box_world.h"

namespace tsg::places {
namespace {

using test::BoxWorld;
using test::kVoxel_m;

/// The world seen through a box, in the form places work on.
struct Seen {
  explicit Seen(const BoxWorld& world, const Aabb& box) : ground(config) {
    mapping::TsdfVolume volume(kVoxel_m);
    const auto blocks = test::observe(world, box, volume);
    ground.updateColumns(voxels, voxels.copyBlocks(volume, blocks));
  }

  std::vector<Floor> floors() const { return ground.computeFloors(kVoxel_m); }
  FreeSpace walkable() const { return makeWalkableSpace(voxels, floors().at(0), config); }

  PlacesConfig config;
  VoxelMap voxels;
  GroundMap ground;
};

const Aabb kView = makeAabb({-1, -1, -0.5}, {8, 8, 2.2});

VoxelMap::Column makeColumn(std::vector<float> distances_m, int min_z = 0) {
  return {min_z, std::move(distances_m)};
}

TEST(Ground, HeightIsInterpolatedBetweenSolidAndFree) {
  // Voxel 2 (centre 0.25) lies 0.03 m deep, voxel 3 (0.35) 0.07 m above the surface at 0.28.
  const auto heights_m =
      findGround(makeColumn({-0.23F, -0.13F, -0.03F, 0.07F, 0.17F, 0.27F}), 0.1, 0.3);
  ASSERT_EQ(heights_m.size(), 1U);
  EXPECT_NEAR(heights_m[0], 0.28, 1e-6);
}

TEST(Ground, NeedsTheWholeBodyObservedFree) {
  const std::vector<float> free{-0.05F, 0.05F, 0.15F, 0.25F};
  EXPECT_EQ(findGround(makeColumn(free), 0.1, 0.3).size(), 1U);
  EXPECT_EQ(findGround(makeColumn(free), 0.1, 0.31).size(), 0U);
  for (std::size_t i = 1; i < free.size(); ++i) {
    auto holed = free;
    holed[i] = kNotObserved;
    EXPECT_TRUE(findGround(makeColumn(holed), 0.1, 0.3).empty());
  }
}

TEST(Ground, OverUnknownIsNoGround) {
  EXPECT_TRUE(findGround(makeColumn({kNotObserved, 0.05F, 0.15F, 0.25F, 0.3F}), 0.1, 0.3).empty());
}

TEST(Ground, EveryStoreyCountsAscending) {
  const auto heights_m =
      findGround(makeColumn({-0.05F, 0.05F, 0.15F, -0.05F, -0.05F, 0.05F, 0.15F}, -10), 0.1, 0.2);
  ASSERT_EQ(heights_m.size(), 2U);
  EXPECT_NEAR(heights_m[0], -0.9, 1e-6);
  EXPECT_NEAR(heights_m[1], -0.5, 1e-6);
}

TEST(Floors, TableIsNoFloorAndUnderItNobodyStands) {
  BoxWorld world;
  world.addRoom(0, 0, 4, 4).add({1, 1, 0.7}, {2.6, 2, 0.75});
  const Seen seen(world, kView);
  const auto floors = seen.floors();
  ASSERT_EQ(floors.size(), 1U);
  EXPECT_TRUE(isUnknown(floors[0].height_m[floors[0].extent.toLinear({18, 15, 0})]));
  const std::size_t beside = floors[0].extent.toLinear({30, 30, 0});
  EXPECT_NEAR(floors[0].height_m[beside], 0.0, 0.02);
}

TEST(Floors, StairsJoinTwoLevelsAndAPlatformStaysApart) {
  BoxWorld world;
  world.addFloor(0, 0, 3, 3);
  for (int step = 1; step <= 5; ++step) {
    world.add({2.0 + 0.3 * step, 0, -0.3}, {2.3 + 0.3 * step, 3, 0.17 * step});
  }
  world.add({3.8, 0, -0.3}, {7, 3, 0.85});
  const Aabb view = makeAabb({0, 0, -0.5}, {7, 3, 2.2});
  EXPECT_EQ(Seen(world, view).floors().size(), 1U);
  BoxWorld cliff;
  cliff.addFloor(0, 0, 3, 3).add({3, 0, -0.3}, {7, 3, 0.85});
  EXPECT_EQ(Seen(cliff, view).floors().size(), 2U);
}

TEST(Floors, ARampOfNoiseDoesNotLeadOntoACabinet) {
  BoxWorld world;
  world.addRoom(0, 0, 5, 5).add({0, 3, 0}, {5, 5, 0.5});
  // One column wide, as interpolation at an edge leaves them.
  world.add({2.0, 2.8, 0}, {2.1, 2.9, 0.17}).add({2.0, 2.9, 0}, {2.1, 3.0, 0.34});
  const auto floors = Seen(world, kView).floors();
  ASSERT_EQ(floors.size(), 2U);
  for (const Floor& floor : floors) {
    float min_m = 10.0F;
    float max_m = -10.0F;
    for (const float height_m : floor.height_m) {
      if (isUnknown(height_m)) continue;
      min_m = std::min(min_m, height_m);
      max_m = std::max(max_m, height_m);
    }
    EXPECT_LT(max_m - min_m, 0.25F);
  }
}

TEST(Floors, UnseenStripIsBridgedOnlyWhileItIsNarrow) {
  BoxWorld world;
  world.addRoom(0, 0, 8, 4);
  for (const double width_m : {0.8, 1.6}) {
    mapping::TsdfVolume volume(kVoxel_m);
    const auto blocks = test::observe(world, kView, volume, [&](const Eigen::Vector3d& p) {
      return p.z() > 0.3 || std::abs(p.x() - 4.0) > width_m / 2.0;
    });
    PlacesConfig config;
    VoxelMap voxels;
    GroundMap ground(config);
    ground.updateColumns(voxels, voxels.copyBlocks(volume, blocks));
    const auto floors = ground.computeFloors(kVoxel_m);
    EXPECT_EQ(floors.size(), width_m < 1.0 ? 1U : 2U);
    const FreeSpace space = makeWalkableSpace(voxels, floors[0], config);
    const std::size_t middle = space.extent.toLinear({40, 20, 0});
    EXPECT_EQ(space.is_free[middle] != 0, width_m < 1.0);
  }
}

TEST(WalkableSpace, ClearanceIsTheDistanceToWhatStandsThere) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> shift_m(0.0, 0.1);
  for (int trial = 0; trial < 8; ++trial) {
    const double x0 = shift_m(random);
    const double y0 = shift_m(random);
    BoxWorld world;
    world.addRoom(x0, y0, x0 + 3.03, y0 + 4.06).add({1, 2, 0}, {1.5, 2.5, 1.2});
    const FreeSpace space = Seen(world, kView).walkable();
    int num_free = 0;
    double sum_of_errors_m = 0.0;
    for (std::size_t cell = 0; cell < space.is_free.size(); ++cell) {
      if (space.is_free[cell] == 0) continue;
      ++num_free;
      const double expected_m =
          std::min(3.0, world.computeHorizontalDistance(space.computePosition(cell), 0.6));
      const double error_m = std::abs(static_cast<double>(space.clearance_m[cell]) - expected_m);
      ASSERT_LT(error_m, kVoxel_m) << cell;
      sum_of_errors_m += error_m;
    }
    EXPECT_LT(sum_of_errors_m / num_free, 0.1 * kVoxel_m);
    EXPECT_GT(num_free, 1000);
  }
}

TEST(WalkableSpace, LowThingsAndLintelsAreNoObstacles) {
  BoxWorld world;
  world.addRoom(0, 0, 5, 5).add({2, 2, 0}, {3, 3, 0.15}).add({0, 2.4, 2.0}, {5, 2.6, 2.5});
  const FreeSpace space = Seen(world, kView).walkable();
  const std::size_t middle = space.extent.toLinear({25, 25, 0});
  EXPECT_TRUE(space.is_free[middle]);
  EXPECT_NEAR(space.clearance_m[middle], 2.5, 0.1);
}

TEST(VolumeSpace, ClearanceIsTheThreeDimensionalDistance) {
  BoxWorld world;
  world.addRoom(0, 0, 3, 3).add({-0.2, -0.2, 2.0}, {3.2, 3.2, 2.2});
  const Seen seen(world, kView);
  const FreeSpace space = makeVolumeSpace(seen.voxels, seen.voxels.columnIndices(), seen.config);
  int num_free = 0;
  for (std::size_t cell = 0; cell < space.is_free.size(); ++cell) {
    const Eigen::Vector3d p = space.computePosition(cell);
    if (space.is_free[cell] == 0 || p.minCoeff() < 0.0 || p.maxCoeff() > 3.0 || p.z() > 2.0) {
      continue;
    }
    ++num_free;
    ASSERT_NEAR(space.clearance_m[cell], world.computeDistance(p), 0.5 * kVoxel_m);
  }
  EXPECT_EQ(num_free, 30 * 30 * 20);
}

TEST(Voronoi, OfACorridorIsItsMiddleLine) {
  BoxWorld world;
  world.addRoom(0, 0, 7, 1.4);
  const Seen seen(world, kView);
  const FreeSpace space = seen.walkable();
  const auto is_voronoi = findVoronoiCells(space, seen.config);
  for (int x = 10; x < 60; ++x) {
    int num_cells = 0;
    for (int y = 0; y < 14; ++y) {
      if (is_voronoi[space.extent.toLinear({x, y, 0})] == 0) continue;
      ++num_cells;
      EXPECT_NEAR((y + 0.5) * kVoxel_m, 0.7, 0.1);
    }
    EXPECT_GE(num_cells, 1) << x;
    EXPECT_LE(num_cells, 2) << x;
  }
}

TEST(Voronoi, CellsKeepTheirDistanceFromObstacles) {
  BoxWorld world;
  world.addRoom(0, 0, 6, 5).add({2, 2, 0}, {3, 2.5, 1}).add({4, 1, 0}, {4.3, 4, 2});
  const Seen seen(world, kView);
  const FreeSpace space = seen.walkable();
  const auto is_voronoi = findVoronoiCells(space, seen.config);
  int num_cells = 0;
  for (std::size_t cell = 0; cell < is_voronoi.size(); ++cell) {
    if (is_voronoi[cell] == 0) continue;
    ++num_cells;
    EXPECT_GE(static_cast<double>(space.clearance_m[cell]), seen.config.min_clearance_m);
    EXPECT_TRUE(space.is_free[cell]);
  }
  EXPECT_GT(num_cells, 50);
}

TEST(LineClearance, IsZeroThroughAWallAndTheNarrowestOtherwise) {
  BoxWorld world;
  world.addRoom(0, 0, 6, 5).add({2.9, 0, 0}, {3.1, 2, 2.5}).add({2.9, 3, 0}, {3.1, 5, 2.5});
  const FreeSpace space = Seen(world, kView).walkable();
  const auto cell = [&](int x, int y) { return space.extent.toLinear({x, y, 0}); };
  EXPECT_EQ(computeLineClearance(space, cell(10, 10), cell(50, 10)), 0.0);
  EXPECT_NEAR(computeLineClearance(space, cell(10, 25), cell(50, 25)), 0.5, 0.1);
  EXPECT_EQ(computeLineClearance(space, cell(10, 25), cell(10, 25)),
            static_cast<double>(space.clearance_m[cell(10, 25)]));
}

}  // namespace
}  // namespace tsg::places
