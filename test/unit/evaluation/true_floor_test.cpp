// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/true_floor.h"

#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>

#include "support.h"
#include "task_scene_graph/mapping/ply.h"
#include "task_scene_graph/simulation/floor_map.h"
#include "task_scene_graph/simulation/world.h"
#include "task_scene_graph/simulation/world_mesh.h"

namespace tsg::evaluation {
namespace {

using places::PlanCell;

void addBox(Mesh& mesh, const Eigen::Vector3d& min_m, const Eigen::Vector3d& max_m) {
  simulation::Apartment world;
  world.solids.resize(1);
  world.solids[0].T_world_solid = Pose(Eigen::Translation3d((min_m + max_m) / 2.0));
  world.solids[0].half_size_m = (max_m - min_m) / 2.0;
  mesh.append(simulation::computeMesh(world));
}

/// A floor of 6 m x 4 m at height 0 between walls of 2.5 m.
Mesh makeRoom() {
  Mesh mesh;
  addBox(mesh, {0, 0, -0.1}, {6, 4, 0});
  addBox(mesh, {-0.2, -0.2, -0.1}, {0, 4.2, 2.5});
  addBox(mesh, {6, -0.2, -0.1}, {6.2, 4.2, 2.5});
  addBox(mesh, {0, -0.2, -0.1}, {6, 0, 2.5});
  addBox(mesh, {0, 4, -0.1}, {6, 4.2, 2.5});
  return mesh;
}

const PlanCell* find(const places::GroundPlan& plan, double x_m, double y_m, double z_m = 0.0) {
  return plan.find(plan.computeCell({x_m, y_m}), z_m, 0.1);
}

TEST(TrueFloor, OfARoomIsAllThatLiesBetweenItsWalls) {
  const auto plan = computeTrueFloor(makeRoom(), {1.025, 1.025, 1.4});
  std::size_t num_free = 0;
  for (const auto& [index, tiles] : plan.tiles()) {
    for (const auto& tile : tiles) {
      for (const PlanCell& cell : *tile) num_free += cell.isFree() ? 1 : 0;
    }
  }
  EXPECT_NEAR(static_cast<double>(num_free) * 0.05 * 0.05, 24.0, 1.1);  // a rim of half a cell
  EXPECT_NEAR(find(plan, 3.025, 1.525)->clearance_m, 1.525, 0.06);
  EXPECT_NEAR(find(plan, 0.525, 2.025)->clearance_m, 0.525, 0.06);
  EXPECT_EQ(find(plan, 3.025, 4.075), nullptr);  // inside a wall, which nobody sees
}

TEST(TrueFloor, TablesAreObstaclesAndLampsRugsAndStepsAreNot) {
  Mesh mesh = makeRoom();
  addBox(mesh, {2, 1, 0.7}, {3, 2, 0.75});  // a table top
  addBox(mesh, {4, 1, 2.0}, {5, 2, 2.3});   // a lamp
  addBox(mesh, {1, 3, 0.0}, {3, 4, 0.02});  // a rug
  addBox(mesh, {4, 3, 0.0}, {6, 4, 0.15});  // a low podium
  const auto plan = computeTrueFloor(mesh, {1.0, 1.0, 1.4});
  EXPECT_EQ(find(plan, 2.025, 1.525)->state, PlanCell::State::kObstacle);
  EXPECT_EQ(find(plan, 2.525, 1.525), nullptr);  // under the middle of the table nobody comes
  EXPECT_TRUE(find(plan, 4.525, 1.525)->isFree());
  EXPECT_TRUE(find(plan, 2.025, 3.525)->isFree());
  ASSERT_NE(find(plan, 5.025, 3.525, 0.15), nullptr);
  EXPECT_TRUE(find(plan, 5.025, 3.525, 0.15)->isFree());
  EXPECT_NEAR(find(plan, 5.025, 3.525, 0.15)->floor_m, 0.15, 0.01);
}

TEST(TrueFloor, StairsJoinTwoStoreysOverOneAnother) {
  Mesh mesh;
  addBox(mesh, {0, 0, -0.1}, {8, 2, 0});
  addBox(mesh, {0, 0, 2.6}, {4, 2, 2.7});  // the upper floor, over the lower one
  for (int i = 1; i <= 15; ++i) {          // up to 2.7 m, against x, with a way past
    addBox(mesh, {8.0 - 0.25 * (i + 1), 1.01, 0.0}, {8.0 - 0.25 * i, 2, 0.18 * i});
  }
  const auto plan = computeTrueFloor(mesh, {1.0, 0.5, 1.4});
  ASSERT_NE(find(plan, 2.025, 1.025, 2.7), nullptr);
  EXPECT_TRUE(find(plan, 2.025, 1.025, 2.7)->isFree());
  EXPECT_TRUE(find(plan, 2.025, 1.025, 0.0)->isFree());
  EXPECT_EQ(find(plan, 6.0, 0.925, 0.0)->state, PlanCell::State::kFree);
  EXPECT_EQ(find(plan, 6.0, 1.025, 0.0)->state, PlanCell::State::kObstacle);  // side of the stairs
}

TEST(TrueFloor, WhatCannotBeWalkedToIsNotThere) {
  Mesh mesh = makeRoom();
  addBox(mesh, {3, 0, 0}, {3.1, 4, 2.5});
  const auto plan = computeTrueFloor(mesh, {1.0, 1.0, 1.4});
  EXPECT_TRUE(find(plan, 2.525, 2.025)->isFree());
  EXPECT_EQ(find(plan, 4.025, 2.025), nullptr);
}

TEST(TrueFloor, IsFreeWhereTheWalkersGridOfAWorldIs) {
  const auto world = simulation::buildWorld(simulation::WorldKind::kApartment, {});
  const simulation::FloorMap grid(world, 0.2, 1.2);
  const Eigen::Vector2d start_m = world.rooms[0].interior_m.center();
  ASSERT_GT(grid.computeClearance(start_m), 0.2);
  const auto plan =
      computeTrueFloor(simulation::computeMesh(world), {start_m.x(), start_m.y(), 1.4});
  std::size_t num_wrong = 0;
  const auto cells = grid.findReachable(start_m, 0.15);
  for (const Eigen::Vector2d& p_m : cells) {
    const PlanCell* cell = plan.find(plan.computeCell(p_m), 0.0, 0.2);
    num_wrong += cell == nullptr || !cell->isFree() ? 1 : 0;
  }
  EXPECT_GT(cells.size(), 10000U);
  EXPECT_EQ(num_wrong, 0U);  // its obstacles are boxes around bodies, so it never knows more
}

TEST(TrueFloor, StartWithoutAFloorIsRefused) {
  EXPECT_THROW(computeTrueFloor(makeRoom(), {20.0, 1.0, 1.4}), std::invalid_argument);
  EXPECT_THROW(computeTrueFloor(makeRoom(), {1.0, 1.0, -1.0}), std::invalid_argument);
  EXPECT_THROW(computeTrueFloor({}, {1.0, 1.0, 1.4}), std::invalid_argument);
}

TEST(TrueFloor, MeshesAreReadBackAndBadOnesNamed) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "mesh.ply";
  const Mesh mesh = makeRoom();
  mapping::writePly(path, mesh);
  const Mesh read = loadMesh(path.string());
  EXPECT_EQ(read.vertices, mesh.vertices);
  EXPECT_EQ(read.triangles, mesh.triangles);
  const auto failOf = [&](const std::string& text) -> std::string {
    std::ofstream(path) << text;
    try {
      loadTrueMesh(path.string());
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float "
      "z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 "
      "0\n0 1 0\n";
  EXPECT_EQ(failOf(head + "4 0 1 2 3\n"), "");
  EXPECT_EQ(loadMesh(path.string()).triangles.size(), 2U);
  EXPECT_NE(failOf(head + "3 0 1 4\n").find("names vertex 4"), std::string::npos);
  EXPECT_NE(failOf(head + "3 0 1\n").find("ends at face 0"), std::string::npos);
  EXPECT_NE(failOf(head + "0\n").find("has no faces"), std::string::npos);
  EXPECT_TRUE(loadMesh(path.string()).isEmpty());
}

}  // namespace
}  // namespace tsg::evaluation
