// SPDX-License-Identifier: BSD-3-Clause
#include "places/floor_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "box_world.h"
#include "layers.h"
#include "places/way_map.h"
#include "sparse_config.h"

namespace tsg::places {
namespace {

using test::BoxWorld;
using test::kVoxel_m;
using test::SeenWorld;

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

/// Height of the plan's free cell at a column that is nearest to a height; NaN if there is none.
double findFloor(const SeenWorld& seen, int x, int y, double near_m) {
  const PlanCell* cell = seen.layers.plan().find({x, y}, near_m, 0.3);
  return cell != nullptr && cell->isFree() ? static_cast<double>(cell->floor_m) : std::nan("");
}

TEST(Floors, TableIsNoFloorAndUnderItNobodyStands) {
  BoxWorld world;
  world.addRoom(0, 0, 4, 4).add({1, 1, 0.7}, {2.6, 2, 0.75});
  const SeenWorld seen(world, kView);
  EXPECT_TRUE(std::isnan(findFloor(seen, 18, 15, 0.0)));
  EXPECT_TRUE(std::isnan(findFloor(seen, 18, 15, 0.75)));
  EXPECT_NEAR(findFloor(seen, 30, 30, 0.0), 0.0, 0.02);
}

TEST(Floors, ABedIsLargeEnoughButLooksDownOnTheFloorAroundIt) {
  BoxWorld world;
  world.addRoom(0, 0, 7, 7).add({0, 0, 0}, {2.4, 2.4, 0.45});
  EXPECT_TRUE(std::isnan(findFloor(SeenWorld(world, kView), 10, 10, 0.45)));
  BoxWorld apart;
  apart.addFloor(0, 0, 2.4, 2.4, 0.45);
  EXPECT_NEAR(findFloor(SeenWorld(apart, kView), 10, 10, 0.45), 0.45, 0.02);
}

TEST(Floors, StairsJoinTwoLevelsAndAPlatformStaysApart) {
  BoxWorld world;
  world.addFloor(0, 0, 6, 6);
  for (int step = 1; step <= 5; ++step) {
    world.add({5.0 + 0.3 * step, 0, -0.3}, {5.3 + 0.3 * step, 6, 0.17 * step});
  }
  world.add({6.8, 0, -0.3}, {9, 6, 0.85});
  const Aabb view = makeAabb({0, 0, -0.5}, {9, 6, 2.2});
  const SeenWorld stairs(world, view);
  EXPECT_EQ(test::findParts(stairs.extractor.graph()).size(), 1U);
  EXPECT_NEAR(findFloor(stairs, 80, 30, 0.85), 0.85, 0.02);
  BoxWorld cliff;
  cliff.addFloor(0, 0, 3, 3).add({3, 0, -0.3}, {9, 6, 0.85});
  EXPECT_EQ(test::findParts(SeenWorld(cliff, view).extractor.graph()).size(), 2U);
}

TEST(Floors, DropsAreEdgesOfMoreThanOneAndAHalfSteps) {
  for (const double fall_m : {0.15, 0.25, 0.35, 1.0}) {  // a step is 0.2 m
    SCOPED_TRACE(fall_m);
    BoxWorld world;
    world.addFloor(0, 0, 10, 7).add({0, 0, -0.3}, {5, 7, fall_m});
    mapping::TsdfVolume volume(kVoxel_m);
    VoxelMap voxels;
    const auto changed =
        voxels.copyBlocks(volume, test::observe(world, makeAabb({0, 0, -0.5}, {10, 7, 3}), volume));
    const TileSet tiles(changed.begin(), changed.end());
    const PlacesConfig config = makeSparseConfig();
    FloorMap floors(config);
    floors.readGround(voxels, tiles);
    floors.update(voxels, WayMap(config), tiles);
    int num_drops = 0;
    for (const TileIndex& index : tiles) {
      floors.forEachDrop(index, [&](const GroundNode& node) {
        ++num_drops;
        EXPECT_NEAR(node.height_m, fall_m, 0.05);
        EXPECT_NEAR((computeColumn(index, node.offset).x + 0.5) * kVoxel_m, 5.0, 0.11);
      });
    }
    EXPECT_EQ(num_drops, fall_m > 0.3 ? 70 : 0);
  }
}

TEST(Floors, ARampOfNoiseDoesNotLeadOntoACabinet) {
  BoxWorld world;
  world.addRoom(0, 0, 7, 7).add({0, 5, 0}, {7, 7, 0.5});
  // One column wide, as interpolation at an edge leaves them.
  world.add({2.0, 4.8, 0}, {2.1, 4.9, 0.17}).add({2.0, 4.9, 0}, {2.1, 5.0, 0.34});
  const SeenWorld seen(world, kView);
  EXPECT_TRUE(std::isnan(findFloor(seen, 20, 60, 0.5)));
  EXPECT_NEAR(findFloor(seen, 20, 30, 0.0), 0.0, 0.02);
}

TEST(Floors, TwoStoreysOverOneAnotherAreBothThere) {
  BoxWorld world;
  world.addRoom(0, 0, 4, 4).addFloor(0, 0, 4, 4, 2.8);
  const SeenWorld seen(world, makeAabb({-1, -1, -0.5}, {5, 5, 4.5}));
  EXPECT_NEAR(findFloor(seen, 20, 20, 0.0), 0.0, 0.02);
  EXPECT_NEAR(findFloor(seen, 20, 20, 2.8), 2.8, 0.02);
  const PlanCell* low = seen.layers.plan().find({20, 20}, 0.0, 0.3);
  EXPECT_NEAR(low->clearance_m, 2.0, 0.11);
}

TEST(Floors, UnseenStripIsBridgedOnlyWhileItIsNarrow) {
  BoxWorld world;
  world.addRoom(0, 0, 7, 4);
  for (const double width_m : {0.8, 1.6}) {
    const SeenWorld seen(world, kView, {}, [&](const Eigen::Vector3d& p) {
      return p.z() > 0.3 || std::abs(p.x() - 4.0) > width_m / 2.0;
    });
    EXPECT_EQ(std::isnan(findFloor(seen, 40, 20, 0.0)), width_m > 1.0);
  }
}

}  // namespace
}  // namespace tsg::places
