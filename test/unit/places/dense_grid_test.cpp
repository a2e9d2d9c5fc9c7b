// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/places/dense_grid.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace tsg::places {
namespace {

std::vector<char> makeRandomSources(std::size_t cells, double density, unsigned seed) {
  std::mt19937 random(seed);
  std::bernoulli_distribution is_source(density);
  std::vector<char> sources(cells);
  for (char& source : sources) source = is_source(random) ? 1 : 0;
  return sources;
}

int squaredDistance(const GridExtent& extent, std::size_t a, std::size_t b) {
  return (extent.toIndex(a) - extent.toIndex(b)).squaredNorm();
}

/// Looks at every source for every cell.
int findNearestBySearch(const GridExtent& extent, const std::vector<char>& sources,
                        std::size_t cell) {
  int nearest = std::numeric_limits<int>::max();
  for (std::size_t s = 0; s < sources.size(); ++s) {
    if (sources[s] != 0) nearest = std::min(nearest, squaredDistance(extent, cell, s));
  }
  return nearest;
}

struct Case {
  GridIndex size;
  double density;
  double max_cells;
};

class NearestFieldOracle : public testing::TestWithParam<Case> {};

TEST_P(NearestFieldOracle, EqualsExhaustiveSearch) {
  const GridExtent extent{{-3, 5, -7}, GetParam().size};
  for (unsigned seed = 0; seed < 5; ++seed) {
    const auto sources = makeRandomSources(extent.numCells(), GetParam().density, seed);
    const NearestField field = computeNearestField(extent, sources, GetParam().max_cells);
    for (std::size_t cell = 0; cell < extent.numCells(); ++cell) {
      const int expected = findNearestBySearch(extent, sources, cell);
      if (expected > GetParam().max_cells * GetParam().max_cells) {
        ASSERT_EQ(field.source[cell], NearestField::kNone);
        continue;
      }
      ASSERT_EQ(field.squared_cells[cell], expected);
      const auto source = static_cast<std::size_t>(field.source[cell]);
      ASSERT_NE(sources[source], 0);
      ASSERT_EQ(squaredDistance(extent, cell, source), expected);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Grids, NearestFieldOracle,
                         testing::Values(Case{{40, 1, 1}, 0.1, 100.0}, Case{{1, 30, 1}, 0.1, 5.0},
                                         Case{{31, 27, 1}, 0.01, 100.0},
                                         Case{{31, 27, 1}, 0.01, 6.5},
                                         Case{{14, 11, 9}, 0.005, 100.0},
                                         Case{{14, 11, 9}, 0.02, 4.0},
                                         Case{{14, 11, 9}, 0.5, 3.0}));

TEST(NearestField, WithoutSourcesNothingIsNear) {
  const GridExtent extent{{0, 0, 0}, {5, 4, 3}};
  const NearestField field = computeNearestField(extent, std::vector<char>(60, 0), 100.0);
  for (const std::int32_t source : field.source) EXPECT_EQ(source, NearestField::kNone);
}

TEST(GridExtent, LinearIndexIsUndoneByToIndex) {
  const GridExtent extent{{-3, 5, -7}, {4, 3, 5}};
  for (std::size_t i = 0; i < extent.numCells(); ++i) {
    EXPECT_TRUE(extent.contains(extent.toIndex(i)));
    EXPECT_EQ(extent.toLinear(extent.toIndex(i)), i);
  }
  EXPECT_FALSE(extent.contains({1, 5, -7}));
  EXPECT_FALSE(extent.contains({-3, 5, -8}));
}

}  // namespace
}  // namespace tsg::places
