// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/places/voxel_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

namespace tsg::places {
namespace {

using Columns = std::vector<VoxelMap::ColumnIndex>;

Columns makeColumns(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> anywhere(-400, 400);
  std::uniform_int_distribution<int> beside(-3, 3);
  std::set<VoxelMap::ColumnIndex> columns;
  for (int i = 0; i < 12; ++i) {
    VoxelMap::ColumnIndex at(anywhere(random), anywhere(random));
    for (int step = 0; step < 30; ++step) {
      columns.insert(at);
      at.first += beside(random);
      at.second += beside(random);
    }
  }
  return {columns.begin(), columns.end()};
}

bool isWithin(const VoxelMap::ColumnIndex& a, const VoxelMap::ColumnIndex& b, int reach) {
  return std::abs(a.first - b.first) <= reach && std::abs(a.second - b.second) <= reach;
}

TEST(Islands, ColumnsWithinReachAreNeverDivided) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    for (const int reach : {1, 2, 8, 13}) {
      const auto islands = splitIntoIslands(makeColumns(seed), reach);
      for (std::size_t i = 0; i < islands.size(); ++i) {
        for (std::size_t j = i + 1; j < islands.size(); ++j) {
          for (const auto& a : islands[i]) {
            for (const auto& b : islands[j]) ASSERT_FALSE(isWithin(a, b, reach));
          }
        }
      }
    }
  }
}

TEST(Islands, HoldEveryColumnOnceInAscendingOrder) {
  const Columns columns = makeColumns(7);
  Columns all;
  for (const auto& island : splitIntoIslands(columns, 2)) {
    EXPECT_TRUE(std::is_sorted(island.begin(), island.end()));
    all.insert(all.end(), island.begin(), island.end());
  }
  std::sort(all.begin(), all.end());
  EXPECT_EQ(all, columns);
}

TEST(Islands, ColumnsFarApartAreDivided) {
  const auto islands = splitIntoIslands({{-3000, -3000}, {0, 0}, {1, 0}, {8, 0}, {1250, 3}}, 2);
  EXPECT_EQ(islands.size(), 3U);
  EXPECT_TRUE(splitIntoIslands({}, 2).empty());
}

}  // namespace
}  // namespace tsg::places
