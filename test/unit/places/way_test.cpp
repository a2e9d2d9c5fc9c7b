// SPDX-License-Identifier: BSD-3-Clause
// The way of the body that carries the camera.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "box_world.h"
#include "layers.h"
#include "places/floor_map.h"
#include "places/way_map.h"
#include "sparse_config.h"

namespace tsg::places {
namespace {

using test::BoxWorld;
using test::findParts;
using test::kVoxel_m;

constexpr double kCameraHeight_m = 1.3;

/// A world seen outside of a gap, walked through.
struct Walked {
  explicit Walked(const BoxWorld& world, const std::vector<CameraPose>& poses,
                  const std::function<bool(const Eigen::Vector3d&)>& is_seen = {},
                  const PlacesConfig& config = makeSparseConfig())
      : extractor(config) {
    const auto blocks =
        test::observe(world, makeAabb({-1, -1, -0.5}, {14, 8, 4.5}), volume, is_seen);
    for (const CameraPose& pose : poses) extractor.addPose(pose);
    extractor.update(volume, blocks, Stamp{1});
  }

  std::size_t numParts() const { return findParts(extractor.graph()).size(); }

  mapping::TsdfVolume volume{kVoxel_m};
  PlaceExtractor extractor;
};

/// Two rooms joined by a door of 0.8 m at x = 4.
BoxWorld makeRooms() {
  BoxWorld world;
  world.addRoom(0, 0, 8.2, 4);
  return world.add({4, 0, 0}, {4.2, 1.5, 2.5}).add({4, 2.3, 0}, {4.2, 4, 2.5});
}

bool isOutsideTheGap(const Eigen::Vector3d& p) { return p.x() < 3.0 || p.x() > 5.2; }

const std::vector<CameraPose> kThroughTheDoor =
    test::walk({1.0, 1.9, kCameraHeight_m}, {7.0, 1.9, kCameraHeight_m});

TEST(Way, JoinsWhatWasSeenOnBothSidesOfUnseenFloor) {
  EXPECT_EQ(Walked(makeRooms(), {}, isOutsideTheGap).numParts(), 2U);
  const Walked walked(makeRooms(), kThroughTheDoor, isOutsideTheGap);
  EXPECT_EQ(walked.numParts(), 1U);
  const PlanCell* cell = walked.extractor.plan().find({41, 19}, 0.0, 0.1);
  ASSERT_NE(cell, nullptr);
  EXPECT_TRUE(cell->isFree());
}

TEST(Way, IsAsWideAsTheBody) {
  const Walked walked(makeRooms(), kThroughTheDoor, isOutsideTheGap);
  for (int y = 0; y < 40; ++y) {
    const PlanCell* cell = walked.extractor.plan().find({41, y}, 0.0, 0.15);
    const double away_m = std::abs((y + 0.5) * kVoxel_m - 1.9);
    if (std::abs(away_m - 0.25) < 0.01) continue;
    EXPECT_EQ(cell != nullptr && cell->isFree(), away_m <= 0.25) << y;
  }
}

TEST(Way, LeavesWhatWasSeenSolidButForItsAxis) {
  BoxWorld world = makeRooms();
  world.add({2.0, 0, 0}, {2.2, 4, 1.0});
  const Walked walked(world, kThroughTheDoor);
  EXPECT_EQ(walked.numParts(), 1U);
  const auto isFree = [&](int y) {
    const PlanCell* cell = walked.extractor.plan().find({21, y}, 0.0, 0.15);
    return cell != nullptr && cell->isFree();
  };
  EXPECT_TRUE(isFree(19) || isFree(18));
  EXPECT_FALSE(isFree(16));
  EXPECT_FALSE(isFree(21));
}

TEST(Way, ThroughAGapTooNarrowForPlacesIsStillThere) {
  BoxWorld world;
  world.addRoom(0, 0, 8.2, 4);
  world.add({4, 0, 0}, {4.2, 1.75, 2.5}).add({4, 2.15, 0}, {4.2, 4, 2.5});
  EXPECT_EQ(Walked(world, {}).numParts(), 2U);
  const Walked walked(world,
                      test::walk({1.0, 1.95, kCameraHeight_m}, {7.0, 1.95, kCameraHeight_m}));
  EXPECT_EQ(walked.numParts(), 1U);
  double narrowest_m = 10.0;
  for (const PlaceEdge& edge : walked.extractor.graph().edges) {
    narrowest_m = std::min(narrowest_m, edge.clearance_m);
  }
  EXPECT_NEAR(narrowest_m, 0.2, 0.1);
}

/// From a floor over stairs from x = 4 to 8 to the one 2.6 m above.
std::vector<CameraPose> walkUp(double height_m = 2.6) {
  auto poses = test::walk({2, 2, kCameraHeight_m}, {4, 2, kCameraHeight_m});
  for (const auto& pose :
       test::walk({4, 2, kCameraHeight_m}, {8, 2, kCameraHeight_m + height_m}, 10.0)) {
    poses.push_back(pose);
  }
  for (const auto& pose :
       test::walk({8, 2, kCameraHeight_m + height_m}, {10, 2, kCameraHeight_m + height_m}, 20.0)) {
    poses.push_back(pose);
  }
  for (std::size_t i = 1; i < poses.size(); ++i) {
    poses[i].stamp = Stamp::fromSeconds(1.0 + 0.1 * static_cast<double>(i));
  }
  return poses;
}

TEST(Way, JoinsStoreysOverStairsThatNobodySaw) {
  BoxWorld world;
  world.addFloor(0, 0, 4, 4).addFloor(8, 0, 12, 4, 2.6);
  EXPECT_EQ(Walked(world, {}).numParts(), 2U);
  EXPECT_EQ(Walked(world, walkUp()).numParts(), 1U);
}

/// Whether a way leads from one position to another, from and to the places nearest to them.
bool isJoined(const PlaceGraph& graph, const Eigen::Vector3d& a_m, const Eigen::Vector3d& b_m) {
  const auto findNearest = [&](const Eigen::Vector3d& p_m) {
    return std::min_element(graph.places.begin(), graph.places.end(),
                            [&](const Place& a, const Place& b) {
                              return (a.position_m - p_m).norm() < (b.position_m - p_m).norm();
                            })
        ->id;
  };
  const PlaceId a = findNearest(a_m);
  const PlaceId b = findNearest(b_m);
  const auto parts = findParts(graph);
  return std::any_of(parts.begin(), parts.end(),
                     [&](const auto& part) { return part.count(a) > 0 && part.count(b) > 0; });
}

TEST(Way, IsNotCutByGroundThatWasSeenBesideIt) {
  // Stairs of which some treads were seen, each a little off the slope of the way.
  std::mt19937 random(1);
  std::uniform_real_distribution<double> draw_off(-0.35, 0.35);
  for (int i = 0; i < 24; ++i) {
    const double rise = 0.6 + 0.1 * (i % 6);
    const double height_m = 4.0 * rise;
    const int width = 1 + i % 3;
    SCOPED_TRACE(i);
    std::bernoulli_distribution is_seen(0.2 + 0.1 * (i % 8));
    BoxWorld world;
    world.addFloor(0, 0, 4, 4).addFloor(8, 0, 12, 4, height_m);
    for (int tread = 0; tread < 40; tread += width) {
      if (!is_seen(random)) continue;
      const double x_m = 4.0 + 0.1 * tread;
      const double z_m = 0.1 * rise * tread + draw_off(random);
      world.add({x_m, 1.5, z_m - 0.3}, {x_m + 0.1 * width, 2.5, z_m});
    }
    const Walked walked(world, walkUp(height_m));
    EXPECT_TRUE(isJoined(walked.extractor.graph(), {2, 2, 0}, {10, 2, height_m}));
  }
}

TEST(Way, OverStairsIsARampWithoutGapsAndAsWideAsTheyAre) {
  // 16 steps between two walls 1 m apart; of each column of the steps the camera saw all or nothing
  BoxWorld world;
  world.addFloor(0, 0, 4, 4).addFloor(8, 0, 12, 4, 2.6);
  world.add({4, 1.3, -0.3}, {8, 1.5, 5}).add({4, 2.5, -0.3}, {8, 2.7, 5});
  for (int step = 0; step < 16; ++step) {
    const double x_m = 4.0 + 0.25 * step;
    world.add({x_m, 1.5, -0.3}, {x_m + 0.25, 2.5, 0.1625 * (step + 1)});
  }
  std::mt19937 random(7);
  std::set<std::pair<int, int>> unseen;
  for (int x = 40; x < 80; ++x) {
    for (int y = 15; y < 25; ++y) {
      if (random() % 2 == 0) unseen.insert({x, y});
    }
  }
  const auto is_seen = [&](const Eigen::Vector3d& p) {
    return unseen.count({static_cast<int>(std::floor(p.x() / kVoxel_m)),
                         static_cast<int>(std::floor(p.y() / kVoxel_m))}) == 0;
  };
  const Walked walked(world, walkUp(), is_seen);
  double before_m = 0.0;
  for (int x = 25; x < 95; ++x) {
    SCOPED_TRACE(x);
    const double slope_m = std::clamp((x + 0.5) * kVoxel_m - 4.0, 0.0, 4.0) * 0.65;
    const PlanCell* cell = walked.extractor.plan().find({x, 20}, slope_m, 0.3);
    ASSERT_NE(cell, nullptr);
    EXPECT_TRUE(cell->isFree());
    EXPECT_GE(cell->clearance_m, 0.35F);
    EXPECT_NEAR(static_cast<double>(cell->floor_m), before_m, 0.2);
    before_m = static_cast<double>(cell->floor_m);
  }
}

TEST(Way, OverARampMarksNoGroundBesideIt) {
  // Up a slope that passes under a floor seen at 1.4 m, and later level above that floor.
  BoxWorld world;
  world.addFloor(0, 0, 6, 6, 1.4);
  PlacesConfig config = makeSparseConfig();
  config.camera_height_m = kCameraHeight_m;
  mapping::TsdfVolume volume(kVoxel_m);
  VoxelMap voxels;
  const auto blocks = test::observe(world, makeAabb({-1, -1, 0.8}, {7, 7, 4}), volume);
  const auto changed = voxels.copyBlocks(volume, blocks);
  const TileSet tiles(changed.begin(), changed.end());
  WayMap way(config);
  for (const CameraPose& pose :
       test::walk({2.0, 2.05, 0.7 + kCameraHeight_m}, {2.8, 2.05, 1.3 + kCameraHeight_m})) {
    way.addPose(pose);
  }
  for (const CameraPose& pose : test::walk({2.0, 2.05, 1.55 + kCameraHeight_m},
                                           {2.8, 2.05, 1.55 + kCameraHeight_m}, 100.0)) {
    way.addPose(pose);
  }
  way.update(kVoxel_m, [](const Eigen::Vector3d&) { return std::vector<float>{}; });
  FloorMap floors(config);
  floors.readGround(voxels, tiles);
  floors.update(voxels, way, tiles);
  int num_walked = 0;
  for (const TileIndex& index : tiles) {
    floors.forEachFloor(index, [&](const GroundNode& node) {
      const Column column = computeColumn(index, node.offset);
      const double off_m = std::abs((column.y + 0.5) * kVoxel_m - 2.05);
      num_walked += node.is_walked ? 1 : 0;
      EXPECT_TRUE(!node.is_walked || off_m < 0.3) << column.x << " " << column.y;
    });
  }
  EXPECT_GT(num_walked, 5);
}

TEST(Way, NeedsPosesThatFollowOneAnother) {
  std::vector<CameraPose> poses = kThroughTheDoor;
  poses.erase(poses.begin() + 20, poses.begin() + 45);
  EXPECT_EQ(Walked(makeRooms(), poses, isOutsideTheGap).numParts(), 2U);
  poses = kThroughTheDoor;
  for (std::size_t i = 30; i < poses.size(); ++i) poses[i].stamp.ns += 60000000000;
  PlacesConfig config = makeSparseConfig();
  EXPECT_EQ(Walked(makeRooms(), poses, isOutsideTheGap, config).numParts(), 1U);
  config.max_way_gap_m = 0.0;
  EXPECT_EQ(Walked(makeRooms(), kThroughTheDoor, isOutsideTheGap, config).numParts(), 2U);
}

TEST(Way, OfOneWrongPoseLeavesNoTrace) {
  const auto before = Walked(makeRooms(), kThroughTheDoor).extractor.graph();
  std::vector<CameraPose> poses = kThroughTheDoor;
  CameraPose wrong = poses[10];
  wrong.T_world_camera.translation().x() = 5000.0;
  poses.insert(poses.begin() + 3, wrong);
  wrong.T_world_camera.translation().x() = std::numeric_limits<double>::quiet_NaN();
  poses.insert(poses.begin() + 8, wrong);
  const auto after = Walked(makeRooms(), poses).extractor.graph();
  ASSERT_EQ(after.places.size(), before.places.size());
  for (std::size_t i = 0; i < after.places.size(); ++i) {
    EXPECT_EQ(after.places[i].position_m, before.places[i].position_m);
  }
}

TEST(Way, HeightOfTheCameraIsThatAboveTheFloorAround) {
  BoxWorld world = makeRooms();
  world.add({0, 0, 0}, {1.5, 4, 0.8});  // what the camera stands before is not the floor
  mapping::TsdfVolume volume(kVoxel_m);
  VoxelMap voxels;
  const auto blocks = test::observe(world, makeAabb({-1, -1, -0.5}, {9, 5, 2.4}), volume);
  const auto changed = voxels.copyBlocks(volume, blocks);
  PlaceLayers layers{makeSparseConfig()};
  EXPECT_FALSE(layers.way().cameraHeight());
  for (const CameraPose& pose : kThroughTheDoor) layers.addPose(pose);
  layers.update(voxels, {changed.begin(), changed.end()});
  ASSERT_TRUE(layers.way().cameraHeight());
  EXPECT_NEAR(*layers.way().cameraHeight(), kCameraHeight_m, 0.05);
  PlacesConfig config = makeSparseConfig();
  config.camera_height_m = 0.7;
  EXPECT_EQ(PlaceLayers(config).way().cameraHeight(), 0.7);
}

}  // namespace
}  // namespace tsg::places
