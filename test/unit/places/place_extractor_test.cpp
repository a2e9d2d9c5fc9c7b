// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/places/place_extractor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include "box_world.h"
#include "graph_checks.h"
#include "sparse_config.h"
#include "synthetic_scene.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/mapping/tsdf_integrator.h"

namespace tsg::places {
namespace {

using test::BoxWorld;
using test::findParts;
using test::kVoxel_m;

const Aabb kEverything = makeAabb({-1, -1, -0.5}, {14, 8, 2.4});

PlaceGraph extract(const BoxWorld& world, const PlacesConfig& config = makeSparseConfig(),
                   const Aabb& seen = kEverything) {
  mapping::TsdfVolume volume(kVoxel_m);
  const auto blocks = test::observe(world, seen, volume);
  PlaceExtractor extractor(config);
  extractor.update(volume, blocks, Stamp{1});
  return extractor.graph();
}

/// Two rooms of 4 x 4 m with a wall between them, at x = 4 + shift .. 4.2 + shift, that has a door
/// of `door_m` with a lintel at 2 m.
BoxWorld makeTwoRooms(double door_m, double shift_m = 0.0) {
  BoxWorld world;
  world.addRoom(0, 0, 8.2, 4);
  const double x0 = 4.0 + shift_m;
  const double y0 = 1.5 + shift_m;
  world.add({x0, 0, 0}, {x0 + 0.2, y0, 2.5}).add({x0, y0 + door_m, 0}, {x0 + 0.2, 4, 2.5});
  return world.add({x0, y0, 2.0}, {x0 + 0.2, y0 + door_m, 2.5});
}

double computeClearance(const BoxWorld& world, const PlacesConfig& config,
                        const Eigen::Vector3d& p) {
  return config.free_space == FreeSpaceKind::kVolume ? world.computeDistance(p)
                                                     : world.computeHorizontalDistance(p, p.z());
}

/// What holds for every graph: sorted, edges between its own places, clearances as stated.
void expectSound(const PlaceGraph& graph, const BoxWorld& world,
                 const PlacesConfig& config = makeSparseConfig()) {
  for (std::size_t i = 0; i < graph.places.size(); ++i) {
    const Place& place = graph.places[i];
    EXPECT_TRUE(place.id.isValid());
    EXPECT_TRUE(i == 0 || graph.places[i - 1].id < place.id);
    EXPECT_GE(place.clearance_m, config.min_clearance_m);
    EXPECT_GT(world.computeDistance(place.position_m), 0.0);
  }
  for (const PlaceEdge& edge : graph.edges) {
    EXPECT_LT(edge.a, edge.b);
    const Eigen::Vector3d a_m = test::findPlace(graph, edge.a).position_m;
    const Eigen::Vector3d b_m = test::findPlace(graph, edge.b).position_m;
    EXPECT_GE(edge.clearance_m, config.min_edge_clearance_m);
    double narrowest_m = config.max_distance_m;
    for (double t = 0.0; t <= 1.0; t += 0.01) {
      narrowest_m = std::min(narrowest_m, computeClearance(world, config, a_m + t * (b_m - a_m)));
    }
    EXPECT_NEAR(narrowest_m, edge.clearance_m, 0.1);
  }
  for (const auto& part : findParts(graph)) {
    EXPECT_GE(part.size(), static_cast<std::size_t>(config.min_component_size));
  }
}

TEST(PlaceExtractor, OneRoomGivesOneConnectedGraphSpreadOverIt) {
  BoxWorld world;
  world.addRoom(0, 0, 5, 4);
  const PlaceGraph graph = extract(world);
  expectSound(graph, world);
  EXPECT_EQ(findParts(graph).size(), 1U);
  EXPECT_GE(graph.places.size(), 5U);
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(1, 1), {4, 1}, {1, 3}, {4, 3}}) {
    const bool is_covered = std::any_of(
        graph.places.begin(), graph.places.end(),
        [&](const Place& place) { return (place.position_m.head<2>() - corner).norm() < 1.0; });
    EXPECT_TRUE(is_covered) << corner.transpose();
  }
}

TEST(PlaceExtractor, PlacesStandOnTheFloorNotInTheAir) {
  BoxWorld world;
  world.addRoom(0, 0, 5, 4).add({1, 1, 0.7}, {2.6, 2, 0.75});
  const PlaceGraph graph = extract(world);
  ASSERT_FALSE(graph.places.empty());
  const Aabb above_table = makeAabb({1, 1, 0}, {2.6, 2, 3});
  for (const Place& place : graph.places) {
    EXPECT_NEAR(place.position_m.z(), 0.5, 0.06);
    EXPECT_FALSE(above_table.contains(place.position_m));
  }
}

class Door : public testing::TestWithParam<int> {};

TEST_P(Door, OfEightyCentimetresConnectsTwoRoomsWhereverTheVoxelsLie) {
  const BoxWorld world = makeTwoRooms(0.8, 0.01 * GetParam());
  const PlaceGraph graph = extract(world);
  expectSound(graph, world);
  EXPECT_EQ(findParts(graph).size(), 1U);
  const auto numBeyond = [&](double sign) {
    return std::count_if(graph.places.begin(), graph.places.end(), [&](const Place& place) {
      return sign * (place.position_m.x() - 4.1) > 0.3;
    });
  };
  EXPECT_GE(numBeyond(1.0), 3);
  EXPECT_GE(numBeyond(-1.0), 3);
}

INSTANTIATE_TEST_SUITE_P(SubVoxelShifts, Door, testing::Range(0, 10));

TEST(PlaceExtractor, ClosedDoorOrSlitKeepsRoomsApart) {
  for (const double door_m : {0.0, 0.3}) {
    const BoxWorld world = makeTwoRooms(door_m);
    const PlaceGraph graph = extract(world);
    expectSound(graph, world);
    EXPECT_EQ(findParts(graph).size(), 2U) << door_m;
  }
}

TEST(PlaceExtractor, CorridorIsAChainAlongItsMiddle) {
  BoxWorld world;
  world.addRoom(0, 0, 12, 1.4);
  const PlaceGraph graph = extract(world);
  expectSound(graph, world);
  EXPECT_EQ(findParts(graph).size(), 1U);
  EXPECT_GE(graph.places.size(), 9U);
  EXPECT_LE(graph.places.size(), 14U);
  for (const Place& place : graph.places) {
    if (place.position_m.x() < 1.0 || place.position_m.x() > 11.0) continue;  // branches to corners
    EXPECT_NEAR(place.position_m.y(), 0.7, 0.11);
    EXPECT_NEAR(place.clearance_m, 0.7, 0.11);
  }
}

/// Two corridors of 1.4 m that cross in (6 + shift, 6 + shift).
BoxWorld makeCrossing(double shift_m) {
  const double low = 5.3 + shift_m;
  const double high = 6.7 + shift_m;
  BoxWorld world;
  world.addRoom(0, 0, 12, 12).add({0, 0, 0}, {low, low, 2.5}).add({high, 0, 0}, {12, low, 2.5});
  return world.add({0, high, 0}, {low, 12, 2.5}).add({high, high, 0}, {12, 12, 2.5});
}

const Aabb kSquare = makeAabb({-1, -1, -0.5}, {13, 13, 2.4});

class Crossing : public testing::TestWithParam<int> {};

TEST_P(Crossing, OfCorridorsHasAPlaceInItsMiddleAsFarFromTheFourCorners) {
  const double shift_m = 0.01 * GetParam();
  const BoxWorld world = makeCrossing(shift_m);
  const PlaceGraph graph = extract(world, makeSparseConfig(), kSquare);
  expectSound(graph, world);
  EXPECT_EQ(findParts(graph).size(), 1U);
  const Eigen::Vector2d middle_m = Eigen::Vector2d::Constant(6.0 + shift_m);
  const auto place = std::min_element(graph.places.begin(), graph.places.end(),
                                      [&](const Place& a, const Place& b) {
                                        return (a.position_m.head<2>() - middle_m).norm() <
                                               (b.position_m.head<2>() - middle_m).norm();
                                      });
  ASSERT_NE(place, graph.places.end());
  EXPECT_LT((place->position_m.head<2>() - middle_m).norm(), kVoxel_m * std::sqrt(2.0));
  EXPECT_NEAR(place->clearance_m, 0.7 * std::sqrt(2.0), kVoxel_m);
  for (const Eigen::Vector2d& arm : {Eigen::Vector2d(1, 6), {11, 6}, {6, 1}, {6, 11}}) {
    EXPECT_TRUE(std::any_of(graph.places.begin(), graph.places.end(), [&](const Place& at) {
      return (at.position_m.head<2>() - arm).norm() < 1.0;
    })) << arm.transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(SubVoxelShifts, Crossing, testing::Values(0, 3, 5, 8));

/// Length of the way over edges between the places nearest to two points.
double computeWay(const PlaceGraph& graph, const Eigen::Vector2d& from_m,
                  const Eigen::Vector2d& to_m) {
  const auto findNearest = [&](const Eigen::Vector2d& p_m) {
    return std::min_element(graph.places.begin(), graph.places.end(),
                            [&](const Place& a, const Place& b) {
                              return (a.position_m.head<2>() - p_m).norm() <
                                     (b.position_m.head<2>() - p_m).norm();
                            })
        ->id;
  };
  std::map<PlaceId, double> length_m{{findNearest(from_m), 0.0}};
  for (std::size_t i = 0; i < graph.places.size(); ++i) {
    for (const PlaceEdge& edge : graph.edges) {
      const double step_m =
          (test::findPlace(graph, edge.a).position_m - test::findPlace(graph, edge.b).position_m)
              .norm();
      for (const auto& [a, b] : {std::pair{edge.a, edge.b}, {edge.b, edge.a}}) {
        if (length_m.count(a) == 0) continue;
        const auto [to, is_new] = length_m.emplace(b, length_m.at(a) + step_m);
        to->second = std::min(to->second, length_m.at(a) + step_m);
      }
    }
  }
  return length_m.at(findNearest(to_m));
}

TEST(PlaceExtractor, RoundABlockThereIsOneCycleUntilTheWayIsBarred) {
  BoxWorld ring;
  ring.addRoom(0, 0, 10, 10).add({1.4, 1.4, 0}, {8.6, 8.6, 2.5});
  const PlaceGraph round = extract(ring, makeSparseConfig(), kSquare);
  expectSound(round, ring);
  ASSERT_EQ(findParts(round).size(), 1U);
  EXPECT_EQ(round.edges.size(), round.places.size());
  EXPECT_LT(computeWay(round, {3.0, 0.7}, {5.2, 0.7}), 3.5);
  ring.add({4.0, 0, 0}, {4.2, 1.4, 2.5});
  const PlaceGraph barred = extract(ring, makeSparseConfig(), kSquare);
  ASSERT_EQ(findParts(barred).size(), 1U);
  const double round_m = 4.0 * 8.6 - 2.2;
  EXPECT_NEAR(computeWay(barred, {3.0, 0.7}, {5.2, 0.7}), round_m, 0.1 * round_m);
}

TEST(PlaceExtractor, UnknownSpaceIsNotFree) {
  BoxWorld world;
  world.addRoom(0, 0, 8, 4);
  mapping::TsdfVolume volume(kVoxel_m);
  const auto blocks = test::observe(world, kEverything, volume, [](const Eigen::Vector3d& p) {
    return p.x() < 3.5 || p.x() > 4.5;
  });
  PlaceExtractor extractor{makeSparseConfig()};
  extractor.update(volume, blocks, Stamp{1});
  const PlaceGraph graph = extractor.graph();
  EXPECT_EQ(findParts(graph).size(), 2U);
  for (const Place& place : graph.places) {
    EXPECT_TRUE(place.position_m.x() < 3.5 || place.position_m.x() > 4.5);
  }
}

TEST(PlaceExtractor, SmallComponentsAreLeftOut) {
  BoxWorld world;
  world.addRoom(0, 0, 2.2, 2.2);
  PlacesConfig config = makeSparseConfig();
  config.min_component_size = 1;
  const std::size_t all = extract(world, config).places.size();
  ASSERT_GE(all, 1U);
  config.min_component_size = static_cast<int>(all) + 1;
  EXPECT_TRUE(extract(world, config).places.empty());
}

TEST(PlaceExtractor, VolumeModeFillsARoomWithoutFloorOrGravity) {
  BoxWorld world;
  world.addRoom(0, 0, 4, 4).add({-0.2, -0.2, 2.2}, {4.2, 4.2, 2.5});
  PlacesConfig config = makeSparseConfig();
  config.free_space = FreeSpaceKind::kVolume;
  const PlaceGraph graph = extract(world, config);
  expectSound(graph, world, config);
  ASSERT_GE(graph.places.size(), 4U);
  for (const Place& place : graph.places) {
    EXPECT_NEAR(place.clearance_m, world.computeDistance(place.position_m), 0.1);
  }
}

/// Grows the known part of a world by half a metre at a time.
TEST(PlaceExtractor, IdsStayWhileTheMapGrows) {
  const BoxWorld world = makeTwoRooms(0.8);
  mapping::TsdfVolume volume(kVoxel_m);
  PlaceExtractor extractor{makeSparseConfig()};
  PlaceGraph before;
  for (double x_m = 1.0; x_m < 9.0; x_m += 0.5) {
    const Aabb strip = makeAabb({x_m - 2.0, -1, -0.5}, {x_m, 8, 2.4});
    extractor.update(volume, test::observe(world, strip, volume), Stamp::fromSeconds(x_m));
    const PlaceGraph graph = extractor.graph();
    for (const Place& old : before.places) {
      // Far from the frontier nothing changes, so nothing may get another id.
      if (old.position_m.x() > x_m - 4.5) continue;
      const Place& same = test::findPlace(graph, old.id);
      EXPECT_EQ(same.position_m, old.position_m);
    }
    before = graph;
  }
  EXPECT_EQ(findParts(before).size(), 1U);
  const PlaceCounters& counters = extractor.counters();
  EXPECT_EQ(counters.places_created - counters.places_removed, before.places.size());
}

TEST(PlaceExtractor, RepeatedUpdateChangesNothing) {
  const BoxWorld world = makeTwoRooms(0.8);
  mapping::TsdfVolume volume(kVoxel_m);
  const auto blocks = test::observe(world, kEverything, volume);
  PlaceExtractor extractor{makeSparseConfig()};
  extractor.update(volume, blocks, Stamp{1});
  const PlaceGraph first = extractor.graph();
  extractor.update(volume, blocks, Stamp{2});
  const PlaceGraph second = extractor.graph();
  EXPECT_EQ(second.stamp, Stamp{2});
  ASSERT_EQ(first.places.size(), second.places.size());
  for (std::size_t i = 0; i < first.places.size(); ++i) {
    EXPECT_EQ(first.places[i].id, second.places[i].id);
    EXPECT_EQ(first.places[i].position_m, second.places[i].position_m);
  }
}

void expectEqual(const PlaceGraph& a, const PlaceGraph& b) {
  ASSERT_EQ(a.places.size(), b.places.size());
  for (std::size_t i = 0; i < a.places.size(); ++i) {
    EXPECT_EQ(a.places[i].id, b.places[i].id);
    EXPECT_EQ(a.places[i].position_m, b.places[i].position_m);
    EXPECT_EQ(a.places[i].clearance_m, b.places[i].clearance_m);
  }
  ASSERT_EQ(a.edges.size(), b.edges.size());
  for (std::size_t i = 0; i < a.edges.size(); ++i) {
    EXPECT_EQ(a.edges[i].a, b.edges[i].a);
    EXPECT_EQ(a.edges[i].b, b.edges[i].b);
    EXPECT_EQ(a.edges[i].clearance_m, b.edges[i].clearance_m);
  }
}

TEST(PlaceExtractor, OrderOfChangedBlocksDoesNotMatter) {
  const BoxWorld world = makeTwoRooms(0.8);
  mapping::TsdfVolume volume(kVoxel_m);
  auto blocks = test::observe(world, kEverything, volume);
  PlaceExtractor sorted{makeSparseConfig()};
  sorted.update(volume, blocks, Stamp{1});
  std::mt19937 random(2);
  std::shuffle(blocks.begin(), blocks.end(), random);
  PlaceExtractor shuffled{makeSparseConfig()};
  shuffled.update(volume, blocks, Stamp{1});
  expectEqual(sorted.graph(), shuffled.graph());
}

TEST(PlaceExtractor, NumberOfThreadsThatIntegrateDoesNotMatter) {
  const std::vector<tsg::test::Solid> room{
      tsg::test::makePlane({0, 0, 0}, {0, 0, 1}, {90, 90, 90}),
      tsg::test::makePlane({4.5, 0, 0}, {-1, 0, 0}, {10, 200, 30}),
      tsg::test::makePlane({0, 1.5, 0}, {0, -1, 0}, {10, 200, 30}),
      tsg::test::makePlane({0, -1.5, 0}, {0, 1, 0}, {30, 20, 200}),
      tsg::test::makeBox(makeAabb({2.5, -0.3, 0}, {3.0, 0.4, 1.0}), {200, 0, 0})};
  const CameraModel camera{160, 120, 131.0, 131.5, 79.5, 59.5};
  std::vector<PlaceGraph> graphs;
  for (const int threads : {1, 2, 5}) {
    mapping::IntegratorConfig config;
    config.voxel_size_m = kVoxel_m;
    config.truncation_m = 0.3;
    config.carve_free_space = true;
    config.num_threads = threads;
    mapping::TsdfIntegrator integrator(config);
    mapping::TsdfVolume volume(kVoxel_m);
    PlaceExtractor extractor{PlacesConfig{}};
    for (int i = 0; i < 10; ++i) {
      const Eigen::Vector3d eye(0.1 * i, 0.2, 1.2);
      auto frame = tsg::test::render(room, camera, tsg::test::lookAt(eye, {3.0, 0.0, 0.4})).frame;
      frame.stamp = Stamp::fromSeconds(0.1 * i);
      const auto changed = integrator.integrate(frame, volume).changed_blocks;
      extractor.addPose({frame.stamp, frame.T_world_camera});
      extractor.update(volume, changed, frame.stamp);
    }
    graphs.push_back(extractor.graph());
  }
  EXPECT_GT(graphs[0].places.size(), 10U);
  expectEqual(graphs[1], graphs[0]);
  expectEqual(graphs[2], graphs[0]);
}

TEST(PlaceExtractor, BlocksThatTheVolumeDropsAreRemembered) {
  const BoxWorld world = makeTwoRooms(0.8);
  mapping::TsdfVolume volume(kVoxel_m);
  const auto blocks = test::observe(world, kEverything, volume);
  PlaceExtractor extractor{makeSparseConfig()};
  extractor.update(volume, blocks, Stamp{1});
  const PlaceGraph before = extractor.graph();
  for (const auto& block : blocks) volume.removeBlock(block);
  extractor.update(volume, blocks, Stamp{2});
  expectEqual(before, extractor.graph());
}

/// Rooms cluttered at random: whatever comes out must be sound.
TEST(PlaceExtractor, RandomFurnitureGivesSoundGraphs) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> x_m(0.0, 7.0);
  std::uniform_real_distribution<double> size_m(0.2, 1.2);
  std::size_t num_places = 0;
  for (int trial = 0; trial < 10; ++trial) {
    BoxWorld world;
    world.addRoom(0, 0, 8, 6);
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3d corner(x_m(random), 0.8 * x_m(random), 0.0);
      world.add(corner, corner + Eigen::Vector3d(size_m(random), size_m(random), 1.5));
    }
    const PlaceGraph graph = extract(world);
    expectSound(graph, world);
    num_places += graph.places.size();
  }
  EXPECT_GT(num_places, 100U);
}

TEST(PlaceExtractor, EmptyOrSolidVolumesHaveNoPlaces) {
  PlaceExtractor extractor{makeSparseConfig()};
  mapping::TsdfVolume volume(kVoxel_m);
  extractor.update(volume, {}, Stamp{1});
  EXPECT_TRUE(extractor.graph().places.empty());
  extractor.update(volume, {{5, 5, 5}}, Stamp{2});
  EXPECT_TRUE(extractor.graph().places.empty());
  volume.allocateBlock({0, 0, 0});
  extractor.update(volume, {{0, 0, 0}}, Stamp{3});
  EXPECT_TRUE(extractor.graph().places.empty());
  EXPECT_EQ(extractor.graph().stamp, Stamp{3});
}

/// What one frame with a wrong pose leaves: a patch of floor with free space above it.
std::vector<mapping::GridIndex> addFarPatch(double far_m, mapping::TsdfVolume& volume) {
  BoxWorld patch;
  patch.addFloor(far_m, far_m, far_m + 3.0, far_m + 3.0);
  return test::observe(patch, makeAabb({far_m, far_m, -0.3}, {far_m + 3.0, far_m + 3.0, 1.6}),
                       volume);
}

class FarPatch : public testing::TestWithParam<FreeSpaceKind> {};

TEST_P(FarPatch, OfAFrameWhosePoseIsOffByKilometresLeavesThePlacesAsTheyAre) {
  PlacesConfig config = makeSparseConfig();
  config.free_space = GetParam();
  mapping::TsdfVolume volume(kVoxel_m);
  const auto blocks = test::observe(makeTwoRooms(0.9), kEverything, volume);
  PlaceExtractor extractor(config);
  extractor.update(volume, blocks, Stamp{1});
  const auto before = extractor.graph().places;
  ASSERT_GT(before.size(), 4U);
  for (const double far_m : {1e3, -3e3, 5e3, 5e5}) {
    extractor.update(volume, addFarPatch(far_m, volume), Stamp{2});
  }
  std::size_t num_near = 0;
  for (const auto& place : extractor.graph().places) {
    if (place.position_m.norm() > 500.0) continue;
    ASSERT_LT(num_near, before.size());
    EXPECT_EQ(place.id, before[num_near].id);
    EXPECT_EQ(place.position_m, before[num_near].position_m);
    ++num_near;
  }
  EXPECT_EQ(num_near, before.size());
}

INSTANTIATE_TEST_SUITE_P(BothKinds, FarPatch,
                         testing::Values(FreeSpaceKind::kWalkable, FreeSpaceKind::kVolume));

TEST(PlaceExtractor, AnotherVoxelSizeIsRejectedWithBothSizes) {
  PlaceExtractor extractor{makeSparseConfig()};
  extractor.update(mapping::TsdfVolume(0.1), {}, Stamp{1});
  try {
    extractor.update(mapping::TsdfVolume(0.2), {}, Stamp{2});
    FAIL() << "accepted";
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("0.2"), std::string::npos);
    EXPECT_NE(std::string(e.what()).find("0.1"), std::string::npos);
  }
}

TEST(PlacesConfig, ErrorNamesTheFieldOutOfRange) {
  PlacesConfig config = makeSparseConfig();
  config.cell_size_m = 0.0;
  EXPECT_THROW(PlaceExtractor{config}, config::ConfigError);
}

}  // namespace
}  // namespace tsg::places
