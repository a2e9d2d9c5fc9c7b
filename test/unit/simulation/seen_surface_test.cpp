// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/seen_surface.h"

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <set>
#include <string>

#include "support.h"
#include "task_scene_graph/simulation/variation.h"
#include "task_scene_graph/simulation/walk.h"
#include "task_scene_graph/simulation/world.h"

namespace tsg::simulation {
namespace {

struct Row {
  Eigen::Vector3d p_m;
  int label = 0;
};

std::vector<Row> read(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  while (std::getline(file, line) && line != "end_header") continue;
  std::vector<Row> rows;
  Row row;
  while (file >> row.p_m.x() >> row.p_m.y() >> row.p_m.z() >> row.label) rows.push_back(row);
  return rows;
}

class Seen : public ::testing::Test {
 protected:
  void SetUp() override {
    WalkConfig config;
    config.rate_hz = 1.0;
    const Renderer renderer(world_, 2);
    const CameraModel camera = makeDefaultCamera(160, 120);
    for (const WalkPose& pose : planWalk(world_, config)) {
      surface_.add(renderer.render(camera, pose.T_world_camera), camera, pose.T_world_camera);
    }
  }

  std::vector<Row> write(const std::vector<TaskTruth>& tasks) const {
    surface_.write(folder_.path() / "labels.ply", world_, tasks);
    return read(folder_.path() / "labels.ply");
  }

  tsg::test::TemporaryFolder folder_;
  Apartment world_ = buildWorld(WorldKind::kCubicle, {1, 6});
  SeenSurface surface_;
};

TEST_F(Seen, PointsOfATaskLieInTheBoxesOfItsThings) {
  const auto tasks = makeGroupTasks(world_, TaskGrain::kFine);
  const auto rows = write(tasks);
  ASSERT_EQ(rows.size(), surface_.size());
  std::set<int> labels;
  for (const Row& row : rows) {
    if (row.label < 0) continue;
    labels.insert(row.label);
    double nearest_m = 1.0;
    for (const std::uint16_t id : tasks.at(static_cast<std::size_t>(row.label)).instances) {
      nearest_m = std::min(nearest_m, world_.instances[id - 1U].box.exteriorDistance(row.p_m));
    }
    ASSERT_LT(nearest_m, 1e-3) << tasks[static_cast<std::size_t>(row.label)].name;
  }
  EXPECT_GE(labels.size(), 8U);
}

TEST_F(Seen, NoTwoPointsShareACell) {
  std::set<std::array<int, 3>> cells;
  for (const Row& row : write({})) {
    EXPECT_EQ(row.label, -1);
    const Eigen::Vector3d cell = ((row.p_m.array() - 1e-4) / 0.05).floor();
    cells.insert(
        {static_cast<int>(cell.x()), static_cast<int>(cell.y()), static_cast<int>(cell.z())});
  }
  // Points on a border of cells may be counted with their neighbour.
  EXPECT_GT(cells.size(), surface_.size() * 8 / 10);
}

TEST_F(Seen, ACoarseTaskHasThePointsOfAllMembers) {
  const auto count = [&](TaskGrain grain, const std::set<std::string>& names) {
    const auto tasks = makeGroupTasks(world_, grain);
    std::size_t points = 0;
    for (const Row& row : write(tasks)) {
      if (row.label >= 0) points += names.count(tasks[static_cast<std::size_t>(row.label)].name);
    }
    return points;
  };
  const std::size_t two = count(TaskGrain::kFine, {"get the green book", "get the yellow book"});
  const std::size_t stacks = count(TaskGrain::kCoarse, {"move the stacks of books"});
  EXPECT_GT(two, 0U);
  EXPECT_GT(stacks, two);
}

}  // namespace
}  // namespace tsg::simulation
