// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/planning/planner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "plan_world.h"
#include "task_scene_graph/config/config.h"

namespace tsg::planning {
namespace {

using test::PlanLevel;
using test::PlanRect;

constexpr double kRadius_m = 0.25;
/// Between the centres of cells, clearance is interpolated.
constexpr double kInterpolation_m = 0.02;

struct World {
  std::vector<PlanLevel> levels;
  PlanRect extent{{0.0, 0.0}, {10.0, 8.0}};

  Planner makePlanner(const PlannerConfig& config = {}, double lattice_m = 0.9) const {
    return {test::drawPlaces(levels, extent, lattice_m), test::drawPlan(levels), config};
  }
  PlanResult plan(const Eigen::Vector3d& start_m, const Eigen::Vector3d& goal_m,
                  double radius_m = kRadius_m) const {
    return makePlanner().plan({start_m, {goal_m, {}}, radius_m});
  }
};

/// What holds for every path: it begins and ends where it was asked to, in steps, with room.
void expectSound(const PlanResult& result, const PlanLevel& level, const PlanRequest& request) {
  ASSERT_TRUE(result.isFound()) << result.message;
  const Path& path = result.path;
  EXPECT_LT((path.points.front().position_m - request.start_m).head<2>().norm(), 1e-9);
  if (!request.goal.object) {
    EXPECT_LT((path.points.back().position_m - request.goal.position_m).head<2>().norm(), 1e-9);
  }
  double least_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    const Eigen::Vector3d& p_m = path.points[i].position_m;
    const double clearance_m = level.computeClearance(p_m.head<2>());
    EXPECT_GE(clearance_m, request.robot_radius_m - kInterpolation_m);
    EXPECT_TRUE(level.findFloor(p_m.head<2>()).has_value());
    least_m = std::min(least_m, clearance_m);
    const Eigen::Vector3d& before_m = path.points[i == 0 ? 0 : i - 1].position_m;
    EXPECT_LE((p_m - before_m).norm(), 0.1 + 1e-9);
  }
  EXPECT_NEAR(path.least_clearance_m, least_m, kInterpolation_m);
}

World makeEmptyRoom() {
  World world;
  world.levels.resize(1);
  world.levels[0].addRoom({{0, 0}, {10, 8}});
  return world;
}

/// Two rooms with a wall at x = 5 .. 5.2, and a door in it.
World makeTwoRooms(double door_min_y, double door_max_y) {
  World world = makeEmptyRoom();
  world.levels[0].addObstacle({{5, 0}, {5.2, door_min_y}});
  world.levels[0].addObstacle({{5, door_max_y}, {5.2, 8}});
  return world;
}

TEST(Planner, AFreeLineIsWalkedStraight) {
  const World world = makeEmptyRoom();
  const PlanRequest request{{1.03, 1.21, 0.0}, {{8.77, 6.4, 0.0}, {}}, kRadius_m};
  const PlanResult result = world.makePlanner().plan(request);
  expectSound(result, world.levels[0], request);
  EXPECT_NEAR(result.path.length_m, std::hypot(7.74, 5.19), 1e-6);
  EXPECT_NEAR(result.path.points.back().yaw_rad, std::atan2(5.19, 7.74), 1e-6);
  EXPECT_EQ(result.message, "");
}

TEST(Planner, TheWayThroughADoorIsThatOfATautString) {
  const World world = makeTwoRooms(6.0, 6.8);
  const PlanRequest request{{4, 2, 0}, {{6.2, 2, 0}, {}}, kRadius_m};
  const PlanResult result = world.makePlanner().plan(request);
  expectSound(result, world.levels[0], request);
  // Round the corners (5, 6) and (5.2, 6) at the radius: tangent, arc, straight, arc, tangent.
  const double to_corner_m = std::hypot(1.0, 4.0);
  const double tangent_m = std::sqrt(to_corner_m * to_corner_m - kRadius_m * kRadius_m);
  const double toward = std::atan2(4.0, 1.0) + std::asin(kRadius_m / to_corner_m);
  const double shortest_m = 2.0 * tangent_m + 2.0 * kRadius_m * toward + 0.2;
  EXPECT_LE(result.path.length_m, 1.02 * shortest_m);
  EXPECT_GE(result.path.length_m, 0.995 * shortest_m);
}

TEST(Planner, ADoorOfTheRobotsWidthIsPassedAndOneNarrowerIsNamed) {
  const World world = makeTwoRooms(3.0, 3.8);
  EXPECT_TRUE(world.plan({1, 1, 0}, {9, 1, 0}, 0.34).isFound());
  const PlanResult result = world.plan({1, 1, 0}, {9, 1, 0}, 0.45);
  ASSERT_EQ(result.status, PlanStatus::kNoWay);
  EXPECT_EQ(result.blockage->kind, Blockage::Kind::kNarrow) << result.message;
  EXPECT_NEAR(result.blockage->position_m.x(), 4.8, 0.4);
  EXPECT_NEAR(result.blockage->position_m.y(), 3.4, 0.5);
}

TEST(Planner, AnObstacleInTheRoomIsPassedOnItsShorterSide) {
  World world = makeEmptyRoom();
  world.levels[0].addObstacle({{4, 2}, {6, 5}});  // the line leads through it at y = 3
  const PlanRequest request{{2, 3, 0}, {{8, 3, 0}, {}}, kRadius_m};
  const PlanResult result = world.makePlanner().plan(request);
  expectSound(result, world.levels[0], request);
  const double to_corner_m = std::hypot(2.0, 1.0);
  const double tangent_m = std::sqrt(to_corner_m * to_corner_m - kRadius_m * kRadius_m);
  const double turn = std::atan2(1.0, 2.0) + std::asin(kRadius_m / to_corner_m);
  const double shortest_m = 2.0 * (tangent_m + kRadius_m * turn) + 2.0;
  EXPECT_NEAR(result.path.length_m, shortest_m, 0.01 * shortest_m);
  for (const PathPoint& point : result.path.points) EXPECT_LT(point.position_m.y(), 3.1);
}

TEST(Planner, StairsLeadFromFloorToFloor) {
  World world;
  world.extent = {{0, 0}, {12, 4}};
  world.levels.resize(2);
  world.levels[0].addFloor({{0, 0}, {3, 4}}).addFloor({{3, 0}, {8, 2}}, 0.0, 0.5);
  world.levels[0].addFloor({{3, 2.2}, {12, 4}});
  world.levels[1].addFloor({{8, 0}, {12, 4}}, 2.5);
  const PlanResult up = world.plan({1, 3, 0}, {11, 3, 2.5});
  ASSERT_TRUE(up.isFound()) << up.message;
  EXPECT_NEAR(up.path.points.back().position_m.z(), 2.5, 1e-6);
  EXPECT_NEAR(up.path.points.front().position_m.z(), 0.0, 1e-6);
  for (std::size_t i = 1; i < up.path.points.size(); ++i) {
    EXPECT_LT(std::abs(up.path.points[i].position_m.z() - up.path.points[i - 1].position_m.z()),
              0.21);
  }
  const PlanResult below = world.plan({1, 3, 0}, {11, 3, 0});
  ASSERT_TRUE(below.isFound());
  EXPECT_NEAR(below.path.length_m, 10.0, 0.01);
  EXPECT_NEAR(below.path.points.back().position_m.z(), 0.0, 1e-6);
}

TEST(Planner, AnUnseenFloorBetweenTwoStoreysIsUnknownSpace) {
  World world;
  world.levels.resize(2);
  world.levels[0].addRoom({{0, 0}, {10, 8}});
  world.levels[1].addFloor({{0, 0}, {10, 8}}, 2.8);
  const PlanResult result = world.plan({1, 1, 0}, {9, 7, 2.8});
  ASSERT_EQ(result.status, PlanStatus::kNoWay);
  EXPECT_EQ(result.blockage->kind, Blockage::Kind::kUnknown);
}

TEST(Planner, AWallInTheWayIsNamedWithTheLastPlace) {
  const World world = makeTwoRooms(8.0, 8.0);
  const PlanResult result = world.plan({1, 4, 0}, {9, 4, 0});
  ASSERT_EQ(result.status, PlanStatus::kNoWay);
  EXPECT_EQ(result.blockage->kind, Blockage::Kind::kObstacle);
  EXPECT_NEAR(result.blockage->position_m.x(), 5.05, 0.1);
  ASSERT_TRUE(result.blockage->last_place.isValid());
  EXPECT_LT(result.blockage->last_m.x(), 5.0);
  EXPECT_GT(result.blockage->last_m.x(), 4.0);
  EXPECT_NE(result.message.find("an obstacle is in the way"), std::string::npos) << result.message;
}

TEST(Planner, FloorThatWasNotSeenIsNamed) {
  World world;
  world.levels.resize(1);
  world.levels[0].addFloor({{0, 0}, {4, 8}}).addFloor({{5, 0}, {10, 8}});
  const PlanResult result = world.plan({1, 4, 0}, {9, 4, 0});
  ASSERT_EQ(result.status, PlanStatus::kNoWay);
  EXPECT_EQ(result.blockage->kind, Blockage::Kind::kUnknown);
  EXPECT_NEAR(result.blockage->position_m.x(), 4.05, 0.11);
}

TEST(Planner, WhatPlacesDoNotJoinIsPlannedOnTheFreeSpace) {
  const World world = makeTwoRooms(6.0, 6.8);
  const Planner planner(PlaceGraph{}, test::drawPlan(world.levels), {});
  const PlanResult result = planner.plan({{1, 1, 0}, {{9, 1, 0}, {}}, kRadius_m});
  ASSERT_TRUE(result.isFound());
  EXPECT_TRUE(result.path.places.empty());
}

TEST(Planner, AWayOfThePlacesThatTheGroundPlanCutsIsRefused) {
  const World world = makeTwoRooms(8.0, 8.0);
  PlaceGraph places;
  for (std::uint64_t i = 1; i <= 4; ++i) {
    const double x = 2.0 * static_cast<double>(i);
    places.places.push_back({PlaceId{i}, {x, 4.05, 0.5}, 1.0, {}, 0});
    if (i > 1) places.edges.push_back({PlaceId{i - 1}, PlaceId{i}, 0.5});
  }
  const Planner planner(places, test::drawPlan(world.levels), {});
  const PlanResult result = planner.plan({{1, 4, 0}, {{9, 4, 0}, {}}, kRadius_m});
  ASSERT_EQ(result.status, PlanStatus::kNoWay);
  EXPECT_NE(result.message.find("the places know a way"), std::string::npos) << result.message;
}

TEST(Planner, WithoutAGroundPlanTheWayOverPlacesIsThePath) {
  const World world = makeTwoRooms(3.0, 4.5);
  const PlaceGraph places = test::drawPlaces(world.levels, world.extent);
  const Planner planner(places, places::GroundPlan(), {});
  const PlanResult result = planner.plan({{1, 1, 0.5}, {{9, 7, 0.5}, {}}, kRadius_m});
  ASSERT_TRUE(result.isFound()) << result.message;
  EXPECT_FALSE(result.path.places.empty());
  EXPECT_GE(result.path.least_clearance_m, kRadius_m);
  EXPECT_EQ(planner.plan({{1, 1, 90}, {{9, 7, 0.5}, {}}, kRadius_m}).status,
            PlanStatus::kStartOutside);
  EXPECT_EQ(planner.plan({{1, 1, 0.5}, {{9, 7, 90}, {}}, kRadius_m}).status,
            PlanStatus::kGoalOutside);
  const PlanResult wide = planner.plan({{1, 1, 0.5}, {{9, 7, 0.5}, {}}, 0.8});
  EXPECT_EQ(wide.status, PlanStatus::kNoWay);
  EXPECT_TRUE(wide.blockage->last_place.isValid());
}

TEST(Planner, ErrorsAreToldApart) {
  const World world = makeTwoRooms(6.0, 6.8);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(world.plan({5.1, 2, 0}, {1, 1, 0}).status, PlanStatus::kStartBlocked);
  EXPECT_EQ(world.plan({50, 2, 0}, {1, 1, 0}).status, PlanStatus::kStartOutside);
  EXPECT_EQ(world.plan({1, 1, 0}, {50, 2, 0}).status, PlanStatus::kGoalOutside);
  EXPECT_EQ(world.plan({1, 1, 0}, {1, 1e300, 0}).status, PlanStatus::kInvalid);
  EXPECT_EQ(world.plan({1, 1, nan}, {1, 1, 0}).status, PlanStatus::kInvalid);
  EXPECT_EQ(world.plan({1, 1, 0}, {nan, 1, 0}).status, PlanStatus::kInvalid);
  EXPECT_EQ(world.plan({1, 1, 0}, {2, 1, 0}, -1.0).status, PlanStatus::kInvalid);
  EXPECT_EQ(Planner({}, places::GroundPlan(), {}).plan({}).status, PlanStatus::kNoMap);
  PlannerConfig config;
  config.goal_tolerance_m = 0.1;
  EXPECT_EQ(world.makePlanner(config).plan({{1, 1, 0}, {{5.1, 1, 0}, {}}, kRadius_m}).status,
            PlanStatus::kGoalBlocked);
  config.spacing_m = 0.0;
  EXPECT_THROW(world.makePlanner(config), config::ConfigError);
}

TEST(Planner, ARobotThatStandsTooNearToAWallFirstGetsAwayFromIt) {
  const World world = makeEmptyRoom();
  const PlanResult result = world.plan({0.08, 4, 0}, {9, 4, 0});
  ASSERT_TRUE(result.isFound()) << result.message;
  EXPECT_NEAR(result.path.least_clearance_m, 0.05, 0.04);
  EXPECT_NEAR(result.path.narrowest_m.x(), 0.08, 0.01);
  for (const PathPoint& point : result.path.points) {
    const double away_m = point.position_m.x();
    if (away_m > 0.4) {
      EXPECT_GE(world.levels[0].computeClearance(point.position_m.head<2>()), kRadius_m - 0.02);
    }
  }
  EXPECT_NE(result.message.find("nearer to an obstacle"), std::string::npos);
}

TEST(Planner, APathToAPointWithoutRoomEndsBesideIt) {
  const World world = makeEmptyRoom();
  const PlanResult result = world.plan({5, 4, 0}, {9.95, 4, 0});
  ASSERT_TRUE(result.isFound()) << result.message;
  EXPECT_NEAR(result.path.points.back().position_m.x(), 9.75, 0.06);
  EXPECT_NE(result.message.find("beside it"), std::string::npos);
}

/// Walls at random, at least `radius_m` of room at start and goal.
struct RandomPlan {
  World world;
  PlanRequest request;
};

Eigen::Vector2d drawRoomyPoint(const PlanLevel& level, const PlanRect& extent, double radius_m,
                               std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  while (true) {
    const Eigen::Vector2d p_m =
        extent.min_m +
        (extent.max_m - extent.min_m).cwiseProduct(Eigen::Vector2d(unit(random), unit(random)));
    if (level.computeClearance(p_m) > radius_m + 0.05) return p_m;
  }
}

RandomPlan drawRandomPlan(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  RandomPlan plan;
  plan.world = makeEmptyRoom();
  const int num_obstacles = 6 + static_cast<int>(random() % 14);
  for (int i = 0; i < num_obstacles; ++i) {
    const Eigen::Vector2d at_m(10.0 * unit(random), 8.0 * unit(random));
    Eigen::Vector2d size_m(0.2 + 1.2 * unit(random), 0.2 + 1.2 * unit(random));
    if (i % 3 == 0) size_m = Eigen::Vector2d(0.15, 1.0 + 3.0 * unit(random));
    if (i % 3 == 1) size_m = Eigen::Vector2d(1.0 + 3.0 * unit(random), 0.15);
    plan.world.levels[0].addObstacle({at_m, at_m + size_m});
  }
  plan.request.robot_radius_m = 0.15 + 0.2 * unit(random);
  const double radius_m = plan.request.robot_radius_m;
  const PlanLevel& level = plan.world.levels[0];
  plan.request.start_m.head<2>() = drawRoomyPoint(level, plan.world.extent, radius_m, random);
  plan.request.goal.position_m.head<2>() =
      drawRoomyPoint(level, plan.world.extent, radius_m, random);
  return plan;
}

/// Length over the shortest, for many plans, ascending; each path is checked.
std::vector<double> measureRatios(unsigned seeds, const PlannerConfig& config, double lattice_m) {
  std::vector<double> ratios;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    SCOPED_TRACE(seed);
    const auto [world, request] = drawRandomPlan(seed);
    const PlanResult result = world.makePlanner(config, lattice_m).plan(request);
    const auto shortest = [&](double radius_m) {
      return test::computeShortestWay(world.levels[0], world.extent, request.start_m.head<2>(),
                                      request.goal.position_m.head<2>(), radius_m);
    };
    // A cell's half diagonal in clearance makes ways appear or vanish.
    const double narrow_m = shortest(request.robot_radius_m - kInterpolation_m);
    if (!result.isFound()) {
      EXPECT_EQ(result.status, PlanStatus::kNoWay);
      EXPECT_FALSE(std::isfinite(shortest(request.robot_radius_m + 0.07))) << result.message;
      continue;
    }
    expectSound(result, world.levels[0], request);
    EXPECT_GE(result.path.length_m, narrow_m / 1.008 - 0.01);
    ratios.push_back(result.path.length_m / narrow_m);
  }
  std::sort(ratios.begin(), ratios.end());
  return ratios;
}

TEST(Planner, PathsThroughRandomRoomsAreCollisionFreeAndNearlyTheShortest) {
  const std::vector<double> ratios = measureRatios(40, {}, 0.9);
  ASSERT_GT(ratios.size(), 25U);
  EXPECT_LE(ratios[ratios.size() / 2], 1.02);
  EXPECT_LE(ratios.back(), 1.25);
  RecordProperty("median", std::to_string(ratios[ratios.size() / 2]));
  RecordProperty("worst", std::to_string(ratios.back()));
}

TEST(Planner, PathsOverPlacesAloneAreNearlyTheShortestToo) {
  PlannerConfig config;
  config.max_search_cells = 0;
  const std::vector<double> ratios = measureRatios(40, config, 0.5);
  ASSERT_GT(ratios.size(), 25U);
  EXPECT_LE(ratios[ratios.size() / 2], 1.05);
  // Where the places know no way that the cells do, the way is longer.
  EXPECT_LE(ratios[ratios.size() * 9 / 10], 1.1);
  EXPECT_LE(ratios.back(), 1.3);
  RecordProperty("median", std::to_string(ratios[ratios.size() / 2]));
  RecordProperty("worst", std::to_string(ratios.back()));
}

OrientedBox makeBox(const Eigen::Vector3d& center_m, const Eigen::Vector3d& size_m,
                    double yaw_rad = 0.0) {
  return {center_m, size_m, yaw_rad};
}

double computeDistance(const OrientedBox& box, const Eigen::Vector3d& p_m) {
  const Eigen::Vector3d local_m = box.rotation().transpose() * (p_m - box.center_m);
  return (local_m.cwiseAbs() - box.size_m / 2.0).cwiseMax(0.0).head<2>().norm();
}

void expectFaces(const Path& path, const OrientedBox& box) {
  const Eigen::Vector3d along_m = box.center_m - path.points.back().position_m;
  EXPECT_NEAR(path.points.back().yaw_rad, std::atan2(along_m.y(), along_m.x()), 1e-9);
}

TEST(PlannerToObjects, EndsBeforeTheObjectAndFacesIt) {
  World world = makeEmptyRoom();
  world.levels[0].addObstacle({{6, 3}, {7, 4}});
  const OrientedBox box = makeBox({6.5, 3.5, 0.5}, {1.0, 1.0, 1.0});
  const PlanRequest request{{1, 3.5, 0}, {{}, box}, kRadius_m};
  const PlanResult result = world.makePlanner().plan(request);
  expectSound(result, world.levels[0], request);
  const double away_m = computeDistance(box, result.path.points.back().position_m);
  EXPECT_GE(away_m, kRadius_m + 0.3);
  EXPECT_LE(away_m, kRadius_m + 0.3 + 0.25);
  EXPECT_LT(result.path.points.back().position_m.x(), 6.0);
  EXPECT_TRUE(result.path.has_view);
  expectFaces(result.path, box);
}

TEST(PlannerToObjects, AnObjectAtAWallIsNotLookedAtThroughIt) {
  World world = makeTwoRooms(6.0, 6.8);
  world.levels[0].addObstacle({{5.2, 1.5}, {5.8, 2.3}});
  const OrientedBox box = makeBox({5.5, 1.9, 0.5}, {0.6, 0.8, 1.0});
  const PlanRequest request{{1, 2, 0}, {{}, box}, kRadius_m};
  const PlanResult result = world.makePlanner().plan(request);
  expectSound(result, world.levels[0], request);
  EXPECT_GT(result.path.points.back().position_m.x(), 5.2);
  EXPECT_TRUE(result.path.has_view);
  expectFaces(result.path, box);
}

TEST(PlannerToObjects, AnObjectOnATableIsSeenOverIt) {
  World world = makeEmptyRoom();
  world.levels[0].addObstacle({{5, 3}, {6.2, 4.6}});
  const OrientedBox cup = makeBox({5.6, 3.8, 0.8}, {0.1, 0.1, 0.1});
  const PlanRequest request{{1, 3.5, 0}, {{}, cup}, kRadius_m};
  const PlanResult result = world.makePlanner().plan(request);
  expectSound(result, world.levels[0], request);
  EXPECT_FALSE(result.path.has_view);
  EXPECT_LE(computeDistance(cup, result.path.points.back().position_m), 1.0);
  expectFaces(result.path, cup);
}

TEST(PlannerToObjects, WhereTheBestStandingPointsCannotBeReachedOthersAreTried) {
  World world = makeEmptyRoom();
  // A box in a pen; the robot stands outside of it, the nearest standing points are inside.
  world.levels[0].addObstacle({{5, 3}, {8, 3.1}}).addObstacle({{5, 5.9}, {8, 6}});
  world.levels[0].addObstacle({{5, 3}, {5.1, 6}}).addObstacle({{7.9, 3}, {8, 6}});
  const OrientedBox box = makeBox({6.5, 4.5, 0.3}, {0.8, 0.8, 0.6});
  const PlanRequest request{{1, 4.5, 0}, {{}, box}, kRadius_m};
  const PlanResult result = world.makePlanner().plan(request);
  expectSound(result, world.levels[0], request);
  EXPECT_FALSE(result.path.has_view);
}

TEST(PlannerToObjects, AnObjectIsGoneToOnItsOwnFloor) {
  World world;
  world.extent = {{0, 0}, {12, 4}};
  world.levels.resize(2);
  world.levels[0].addFloor({{0, 0}, {3, 4}}).addFloor({{3, 0}, {8, 2}}, 0.0, 0.5);
  world.levels[0].addFloor({{3, 2.2}, {12, 4}});
  world.levels[1].addFloor({{8, 0}, {12, 4}}, 2.5);
  const OrientedBox box = makeBox({11, 3.5, 3.2}, {0.4, 0.4, 0.4});
  const PlanResult up = world.makePlanner().plan({{1, 1, 0}, {{}, box}, kRadius_m});
  ASSERT_TRUE(up.isFound()) << up.message;
  EXPECT_NEAR(up.path.points.back().position_m.z(), 2.5, 1e-6);
}

TEST(PlannerToObjects, AnObjectFarFromAnyFloorIsRefused) {
  const World world = makeEmptyRoom();
  const OrientedBox outside = makeBox({30, 3, 0.5}, {1, 1, 1});
  EXPECT_EQ(world.makePlanner().plan({{1, 1, 0}, {{}, outside}, kRadius_m}).status,
            PlanStatus::kGoalBlocked);
  const OrientedBox high = makeBox({5, 3, 6.0}, {0.4, 0.4, 0.4});
  EXPECT_EQ(world.makePlanner().plan({{1, 1, 0}, {{}, high}, kRadius_m}).status,
            PlanStatus::kGoalBlocked);
  OrientedBox broken = high;
  broken.yaw_rad = std::numeric_limits<double>::infinity();
  EXPECT_EQ(world.makePlanner().plan({{1, 1, 0}, {{}, broken}, kRadius_m}).status,
            PlanStatus::kInvalid);
}

}  // namespace
}  // namespace tsg::planning
