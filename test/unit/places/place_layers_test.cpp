// SPDX-License-Identifier: BSD-3-Clause
// Updates against one computation with everything, and clearances against exhaustive search.
#include "places/place_layers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "box_world.h"
#include "layers.h"
#include "sparse_config.h"

namespace tsg::places {
namespace {

using test::BoxWorld;
using test::kVoxel_m;

/// A map that is edited: rooms in which boxes come and go, seen piece by piece, and walked.
class EditedMap {
 public:
  EditedMap(const PlacesConfig& config, unsigned seed)
      : config_(config), random_(seed), layers(config) {}

  /// What the sensor sees of the world as it is now, in a random box.
  TileSet edit() {
    if (boxes_.empty() || draw(0.0, 1.0) < 0.7) {
      const Eigen::Vector3d corner(draw(0.0, 8.0), draw(0.0, 6.0), 0.0);
      boxes_.emplace_back(corner,
                          corner + Eigen::Vector3d(draw(0.1, 1.5), draw(0.1, 1.5), draw(0.1, 1.5)));
    } else {
      boxes_.erase(boxes_.begin());
    }
    BoxWorld world;
    world.addRoom(0, 0, 9, 7).add({4.4, 0, 0}, {4.6, 3, 2.5}).add({4.4, 3.9, 0}, {4.6, 7, 2.5});
    for (const auto& [min, max] : boxes_) world.add(min, max);
    const Eigen::Vector3d from(draw(-0.5, 7.0), draw(-0.5, 5.0), -0.5);
    const Eigen::Vector3d to = from + Eigen::Vector3d(draw(1.0, 4.0), draw(1.0, 4.0), 2.4);
    const auto blocks = test::observe(world, Aabb(from, to), volume_);
    const auto changed = voxels.copyBlocks(volume_, blocks);
    return {changed.begin(), changed.end()};
  }

  void walk() {
    const Eigen::Vector3d from(draw(0.5, 4.0), draw(3.2, 3.7), 1.2);
    const Eigen::Vector3d to(draw(5.0, 8.0), draw(3.2, 3.7), 1.2);
    for (const CameraPose& pose : test::walk(from, to, time_s_)) layers.addPose(pose);
    time_s_ += 100.0;
  }

  double draw(double min, double max) {
    return std::uniform_real_distribution<double>(min, max)(random_);
  }

 private:
  PlacesConfig config_;
  std::mt19937 random_;
  mapping::TsdfVolume volume_{kVoxel_m};
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> boxes_;
  double time_s_ = 1.0;

 public:
  VoxelMap voxels;
  PlaceLayers layers;
};

void expectSamePlan(const GroundPlan& a, const GroundPlan& b) {
  ASSERT_EQ(a.tiles().size(), b.tiles().size());
  for (const auto& [index, tiles] : a.tiles()) {
    const auto& others = b.tilesAt(index);
    ASSERT_EQ(tiles.size(), others.size());
    for (std::size_t i = 0; i < tiles.size(); ++i) EXPECT_EQ(*tiles[i], *others[i]);
  }
}

/// Of every place that is kept: clearance, edges, edges of the walk.
std::map<std::vector<int>, std::vector<double>> describeGraph(const PlaceLinks& links) {
  std::map<std::vector<int>, std::vector<double>> graph;
  for (const auto& [key, node] : links.nodes()) {
    if (!node.is_kept) continue;
    const auto name = [own = key](const GridIndex& to) {
      return std::vector<int>{own.x(), own.y(), own.z(), to.x(), to.y(), to.z()};
    };
    graph[name(key)].push_back(static_cast<double>(node.seed.clearance_m));
    node.forEachEdge(
        [&](const GridIndex& to, double clearance_m) { graph[name(to)].push_back(clearance_m); });
  }
  return graph;
}

class Updates : public testing::TestWithParam<std::pair<FreeSpaceKind, unsigned>> {};

TEST_P(Updates, GiveTheFieldAndTheGraphOfOneComputationWithEverything) {
  PlacesConfig config = makeSparseConfig();
  config.free_space = GetParam().first;
  EditedMap map(config, GetParam().second);
  const int num_edits = config.free_space == FreeSpaceKind::kVolume ? 8 : 30;
  for (int edit = 0; edit < num_edits; ++edit) {
    if (edit % 7 == 3) map.walk();
    map.layers.update(map.voxels, map.edit());
    if (edit % 5 != 4 && edit + 1 != num_edits) continue;
    PlaceLayers whole(config);
    whole.updateAll(map.voxels, map.layers.way());
    expectSamePlan(map.layers.plan(), whole.plan());
    const auto graph = describeGraph(whole.links());
    EXPECT_EQ(describeGraph(map.layers.links()), graph) << "after " << edit;
    EXPECT_GT(graph.size(), edit > 10 ? 20U : 0U);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, Updates,
                         testing::Values(std::pair{FreeSpaceKind::kWalkable, 1U},
                                         std::pair{FreeSpaceKind::kWalkable, 2U},
                                         std::pair{FreeSpaceKind::kWalkable, 3U},
                                         std::pair{FreeSpaceKind::kVolume, 4U}));

/// Floors of many tiles hang together, fall apart and count or not by what is far away.
TEST(FloorUpdates, StripByStripGiveTheFloorOfOneComputation) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> draw_m(0.0, 12.0);
  BoxWorld world;
  world.addRoom(0, 0, 12, 12).add({8, 8, 0}, {10, 10, 0.45}).add({2, 3, 0}, {4, 5, 0.45});
  mapping::TsdfVolume volume(kVoxel_m);
  VoxelMap voxels;
  PlaceLayers layers(makeSparseConfig());
  for (int strip = 0; strip < 30; ++strip) {
    const double x_m = strip < 15 ? 0.8 * strip : draw_m(random);
    const Aabb box = makeAabb({x_m - 0.5, -0.5, -0.5}, {x_m + 0.5, strip % 2 == 0 ? 12.5 : 7.0, 2});
    const auto changed = voxels.copyBlocks(volume, test::observe(world, box, volume));
    layers.update(voxels, {changed.begin(), changed.end()});
    PlaceLayers whole(makeSparseConfig());
    whole.updateAll(voxels, layers.way());
    expectSamePlan(layers.plan(), whole.plan());
    EXPECT_EQ(describeGraph(layers.links()), describeGraph(whole.links())) << "after " << strip;
  }
}

/// Every obstacle is looked at for every cell.
TEST(Clearance, EqualsExhaustiveSearchAfterRandomEdits) {
  EditedMap map(makeSparseConfig(), 5);
  for (int edit = 0; edit < 25; ++edit) map.layers.update(map.voxels, map.edit());
  struct Obstacle {
    Column at;
    int slab;
    double offset_m;
  };
  const auto toSlab = [](float level_m) { return std::lround(level_m / 0.5F); };
  std::vector<Obstacle> obstacles;
  const SpaceMap& space = map.layers.space();
  for (const TileIndex& index : map.voxels.columnIndices()) {
    const SpaceTile* tile = space.find(index);
    if (tile == nullptr) continue;
    for (const SpaceCell& cell : tile->cells) {
      if (cell.is_free) continue;
      obstacles.push_back({computeColumn(index, cell.offset),
                           static_cast<int>(toSlab(cell.level_m)),
                           static_cast<double>(cell.offset_m)});
    }
  }
  int num_cells = 0;
  test::forEachFree(space, map.voxels.columnIndices(), [&](const SpaceCell& cell, const auto& p) {
    const int x = static_cast<int>(std::floor(p.x() / kVoxel_m));
    const int y = static_cast<int>(std::floor(p.y() / kVoxel_m));
    int nearest = 50 * 50 + 1;
    for (const Obstacle& obstacle : obstacles) {
      if (std::abs(obstacle.slab - toSlab(cell.level_m)) > 1) continue;
      const int dx = obstacle.at.x - x;
      const int dy = obstacle.at.y - y;
      nearest = std::min(nearest, dx * dx + dy * dy);
    }
    ++num_cells;
    ASSERT_EQ(cell.has_parent, nearest <= 50 * 50);
    if (!cell.has_parent) return;
    const GridIndex to_parent = cell.parent - GridIndex(x, y, 0);
    ASSERT_EQ(to_parent.squaredNorm(), nearest);
    ASSERT_NEAR(cell.clearance_m, std::sqrt(nearest) * kVoxel_m, 0.087);
  });
  EXPECT_GT(num_cells, 1000);
  EXPECT_GT(obstacles.size(), 100U);
}

}  // namespace
}  // namespace tsg::places
