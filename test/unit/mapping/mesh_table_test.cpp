// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/mesh_table.h"

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <random>

#include "task_scene_graph/mapping/tsdf_integrator.h"

namespace tsg::mapping {
namespace {

using Key = std::array<int, 3>;  // (z, y, x): the order of blocks

Key toKey(const GridIndex& block) { return {block.z(), block.y(), block.x()}; }

std::shared_ptr<const Mesh> makeMesh(float value) {
  Mesh mesh;
  mesh.vertices = {{value, 0, 0}, {value, 1, 0}, {value, 0, 1}};
  mesh.colors.resize(3);
  mesh.triangles = {{0, 1, 2}};
  return std::make_shared<const Mesh>(mesh);
}

/// The table and, beside it, a plain map with the same changes.
class Pair {
 public:
  explicit Pair(unsigned seed) : random_(seed) {}

  void change() {
    std::map<Key, MeshTable::Entry> changes;
    for (int i = 0; i < 12; ++i) {
      const GridIndex block(draw(-6, 6), draw(-6, 6), draw(-2, 1));
      const bool is_removed = draw(0, 2) == 0;
      changes[toKey(block)] = {block, is_removed ? StoredMesh() : StoredMesh(makeMesh(next_ += 1))};
    }
    std::vector<MeshTable::Entry> entries;
    for (const auto& [key, entry] : changes) entries.push_back(entry);
    std::shuffle(entries.begin(), entries.end(), random_);
    table = table.with(entries);
    for (const auto& [key, entry] : changes) {
      if (entry.mesh.isNone()) {
        expected.erase(key);
      } else {
        expected[key] = entry.mesh.load();
      }
    }
  }

  MeshTable table;
  std::map<Key, std::shared_ptr<const Mesh>> expected;

 private:
  int draw(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  std::mt19937 random_;
  float next_ = 0.0F;
};

void expectSame(const MeshTable& table,
                const std::map<Key, std::shared_ptr<const Mesh>>& expected) {
  ASSERT_EQ(table.numBlocks(), expected.size());
  std::vector<Key> blocks;
  for (const auto& block : table.blocks()) blocks.push_back(toKey(block));
  std::vector<Key> expected_blocks;
  for (const auto& [key, mesh] : expected) {
    expected_blocks.push_back(key);
    EXPECT_EQ(table.find({key[2], key[1], key[0]}).load(), mesh);
  }
  EXPECT_EQ(blocks, expected_blocks);
}

TEST(MeshTable, HoldsWhatAPlainMapHolds) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Pair pair(seed);
    for (int step = 0; step < 30; ++step) {
      pair.change();
      ASSERT_NO_FATAL_FAILURE(expectSame(pair.table, pair.expected));
    }
  }
}

TEST(MeshTable, ATableNeverChanges) {
  Pair pair(5);
  for (int step = 0; step < 10; ++step) pair.change();
  const MeshTable before = pair.table;
  const auto expected = pair.expected;
  for (int step = 0; step < 10; ++step) pair.change();
  expectSame(before, expected);
}

TEST(MeshTable, ChunksWithoutAChangeAreSharedAndThoseWithoutABlockGone) {
  const MeshTable first = MeshTable().with({{{0, 0, 0}, StoredMesh(makeMesh(1))},
                                            {{3, 3, 3}, StoredMesh(makeMesh(2))},
                                            {{-1, 0, 0}, StoredMesh(makeMesh(3))}});
  ASSERT_EQ(first.chunks().size(), 2U);
  EXPECT_EQ(first.findChunk({0, 0, 0})->size(), 2U);
  const MeshTable second = first.with({{{-1, 0, 0}, StoredMesh()}, {{9, 9, 9}, StoredMesh()}});
  EXPECT_EQ(second.findChunk({0, 0, 0}), first.findChunk({0, 0, 0}));
  EXPECT_EQ(second.findChunk({-1, 0, 0}), nullptr);
  EXPECT_EQ(second.chunks().size(), 1U);
}

TEST(MeshTable, MeshesPutAwayAreReadBack) {
  MeshArchive archive;
  const MeshTable table = MeshTable().with(
      {{{1, 2, 3}, StoredMesh(archive.store(*makeMesh(7)))}, {{1, 2, 4}, StoredMesh(makeMesh(8))}});
  EXPECT_FALSE(table.find({1, 2, 3}).isInMemory());
  EXPECT_EQ(table.find({1, 2, 3}).load()->vertices, makeMesh(7)->vertices);
  EXPECT_EQ(mergeMeshes(table).triangles.size(), 2U);
  EXPECT_EQ(table.find({1, 2, 5}).load(), nullptr);
}

}  // namespace
}  // namespace tsg::mapping
