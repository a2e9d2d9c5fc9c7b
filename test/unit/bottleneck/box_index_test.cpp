// SPDX-License-Identifier: BSD-3-Clause
#include "bottleneck/box_index.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace tsg::bottleneck {
namespace {

Aabb makeBox(std::mt19937& random) {
  // Corners on a grid, so that many boxes touch; some are flat.
  const auto pick = [&](int count) {
    return static_cast<double>(random() % static_cast<unsigned>(count));
  };
  const Eigen::Vector3d min(pick(8), pick(8), pick(8));
  return makeAabb(min, min + Eigen::Vector3d(pick(3), 1.0 + pick(2), 1.0 + pick(2)));
}

TEST(BoxIndex, FindsWhatComparingAllPairsFinds) {
  std::mt19937 random(3);
  BoxIndex index;
  std::map<std::uint32_t, Aabb> boxes;
  for (int step = 0; step < 300; ++step) {
    std::vector<BoxIndex::Entry> added;
    for (unsigned i = 0; i < random() % 4; ++i) {
      const auto id = static_cast<std::uint32_t>(boxes.size() + 1000 * static_cast<unsigned>(step));
      added.emplace_back(boxes[id] = makeBox(random), id);
    }
    index.insert(added);
    if (!boxes.empty() && random() % 2 == 0) {
      const auto gone = std::next(boxes.begin(), static_cast<int>(random() % boxes.size()));
      index.remove({gone->second, gone->first});
      boxes.erase(gone);
    }
    const Aabb query = makeBox(random);
    std::vector<std::uint32_t> expected;
    for (const auto& [id, box] : boxes) {
      if (hasOverlap(query, box)) expected.push_back(id);
    }
    ASSERT_EQ(index.findOverlapping(query), expected);
  }
  EXPECT_GT(boxes.size(), 100u);
}

TEST(BoxIndex, PublishedOverlaps) {
  BoxIndex index;
  const auto along = [](double min, double max) { return makeAabb({min, -1, -1}, {max, 1, 1}); };
  index.insert({{along(-1, 1), 0}, {along(0.5, 1.5), 1}, {along(2, 3), 2}});
  EXPECT_EQ(index.findOverlapping(along(-1, 1)), (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(index.findOverlapping(along(1.2, 2.5)), (std::vector<std::uint32_t>{1, 2}));
  EXPECT_TRUE(index.findOverlapping(makeAabb({3, 3, 3}, {4, 4, 4})).empty());
  BoxIndex cubes;
  cubes.insert({{makeAabb({1, 1, 1}, {2, 2, 2}), 0}, {makeAabb({1, 1, 1}, {3.5, 3.5, 3.5}), 1}});
  EXPECT_EQ(cubes.findOverlapping(makeAabb({3, 3, 3}, {4, 4, 4})), (std::vector<std::uint32_t>{1}));
}

TEST(BoxIndex, EmptyBoxesOverlapNothing) {
  BoxIndex index;
  index.insert({{Aabb(), 5}, {makeAabb({0, 0, 0}, {1, 1, 1}), 6}});
  EXPECT_TRUE(index.findOverlapping(Aabb()).empty());
  EXPECT_EQ(index.findOverlapping(makeAabb({-9, -9, -9}, {9, 9, 9})),
            (std::vector<std::uint32_t>{6}));
}

}  // namespace
}  // namespace tsg::bottleneck
