// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>

#include "task_scene_graph/ros/image_conversions.h"
#include "task_scene_graph/ros/mesh_update_conversions.h"

namespace tsg::ros_interface {
namespace {

using mapping::GridIndex;
using Reader = MeshUpdateReader;
using Messages = std::vector<msg::MeshUpdate>;

const Stamp kStamp{12345678901};

bool isSame(const Reader::Blocks& a, const Reader::Blocks& b) {
  const auto same_block = [](const auto& left, const auto& right) {
    return left.first == right.first && left.second->vertices == right.second->vertices &&
           left.second->colors == right.second->colors &&
           left.second->triangles == right.second->triangles;
  };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same_block);
}

/// A mesh that changes at random, and what is sent of it.
class ChangingMesh {
 public:
  explicit ChangingMesh(unsigned seed) : engine_(seed) {}

  Messages change() {
    mapping::MeshUpdate update;
    for (int i = integer(0, 6); i > 0; --i) {
      const GridIndex block(integer(-3, 3), integer(-2, 2), integer(0, 1));
      if (is_touched(update, block)) continue;
      if (integer(0, 3) == 0) {
        if (blocks_.erase(block) > 0) update.removed.push_back(block);
      } else {
        blocks_[block] = makeMesh();
        update.changed.push_back({block, blocks_[block]});
      }
    }
    Messages messages;
    writer_.sendChanges(update, kStamp, [&](const auto& part) { messages.push_back(part); });
    return messages;
  }
  std::vector<GridIndex> indices() const {
    std::vector<GridIndex> indices;
    for (const auto& [block, mesh] : blocks_) indices.push_back(block);
    return indices;
  }
  msg::MeshUpdate part(const std::vector<GridIndex>& of, std::size_t& next,
                       std::uint32_t part) const {
    std::vector<mapping::MeshTable::Entry> entries;
    for (const auto& [block, mesh] : blocks_) {
      entries.push_back({block, mapping::StoredMesh(mesh)});
    }
    return writer_.makePart(of, next, mapping::MeshTable().with(entries), kStamp, part);
  }
  Messages all() const {
    Messages messages;
    std::size_t next = 0;
    do {
      messages.push_back(part(indices(), next, static_cast<std::uint32_t>(messages.size() + 1)));
    } while (messages.back().is_last == 0);
    return messages;
  }
  msg::MeshUpdate clear() {
    blocks_.clear();
    writer_.skip();
    return writer_.makeEmpty(kStamp);
  }
  void skip() { writer_.skip(); }
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(engine_); }
  const Reader::Blocks& blocks() const { return blocks_; }

 private:
  static bool is_touched(const mapping::MeshUpdate& update, const GridIndex& block) {
    for (const auto& changed : update.changed) {
      if (changed.block == block) return true;
    }
    return std::find(update.removed.begin(), update.removed.end(), block) != update.removed.end();
  }
  std::shared_ptr<const Mesh> makeMesh() {
    auto mesh = std::make_shared<Mesh>();
    const int num_vertices = integer(0, 9) == 0 ? 30000 : integer(3, 30);
    for (int i = 0; i < num_vertices; ++i) {
      mesh->vertices.emplace_back(static_cast<float>(integer(0, 999)), 0.5F, -1.25F);
      mesh->colors.push_back({static_cast<std::uint8_t>(integer(0, 255)), 1, 2});
    }
    mesh->triangles = {{0, 1, static_cast<std::uint32_t>(num_vertices - 1)}};
    return mesh;
  }

  std::mt19937 engine_;
  Reader::Blocks blocks_;
  MeshUpdateWriter writer_{"world", 0.4};
};

void applyAll(Reader& reader, const Messages& messages) {
  for (const auto& message : messages) {
    ASSERT_EQ(reader.apply(message).status, Reader::Status::kApplied);
  }
}

TEST(MeshUpdates, ChangesAddUpToTheWholeMesh) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    ChangingMesh mesh(seed);
    Reader follower;
    for (int step = 0; step < 40; ++step) {
      applyAll(follower, mesh.change());
      Reader newcomer;
      applyAll(newcomer, mesh.all());
      ASSERT_TRUE(isSame(newcomer.blocks(), mesh.blocks())) << "seed " << seed << " step " << step;
      ASSERT_TRUE(isSame(follower.blocks(), mesh.blocks())) << "seed " << seed << " step " << step;
      if (mesh.integer(0, 3) == 0) follower = std::move(newcomer);  // and it follows from here
    }
  }
}

TEST(MeshUpdates, WhateverMessageIsLostIsNoticedAndTheWholeMeshMendsIt) {
  std::size_t num_lost = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    ChangingMesh mesh(seed);
    Reader reader;
    for (int i = 0; i < 10; ++i) mesh.change();
    Messages messages = mesh.all();
    for (int i = 0; i < 5; ++i) {
      for (auto& message : mesh.change()) messages.push_back(std::move(message));
    }
    if (messages.size() < 3) continue;
    const int gap = mesh.integer(1, static_cast<int>(messages.size()) - 2);
    messages.erase(messages.begin() + gap);
    while (messages.size() < 200) {  // the loss of the last part is noticed only by what follows
      for (auto& message : mesh.change()) messages.push_back(std::move(message));
    }
    std::size_t lost_here = 0;
    for (const auto& message : messages) {
      lost_here += reader.apply(message).status == Reader::Status::kLost ? 1 : 0;
    }
    EXPECT_EQ(lost_here, 1U) << "seed " << seed;
    EXPECT_FALSE(reader.hasWholeMesh());
    num_lost += lost_here;
    applyAll(reader, mesh.all());
    EXPECT_TRUE(reader.hasWholeMesh());
    EXPECT_TRUE(isSame(reader.blocks(), mesh.blocks())) << "seed " << seed;
  }
  EXPECT_GT(num_lost, 40U);
}

TEST(MeshUpdates, ChangesBeforeTheWholeMeshAreIgnored) {
  ChangingMesh mesh(3);
  while (mesh.change().empty()) continue;
  Messages later;
  while (later.empty()) later = mesh.change();
  Reader reader;
  EXPECT_EQ(reader.apply(later.front()).status, Reader::Status::kWaiting);
  EXPECT_TRUE(reader.blocks().empty());
  applyAll(reader, mesh.all());
  EXPECT_TRUE(isSame(reader.blocks(), mesh.blocks()));
}

TEST(MeshUpdates, UpdatesThatNobodyWasToldOfAreAGap) {
  ChangingMesh mesh(4);
  Reader reader;
  applyAll(reader, mesh.all());
  mesh.change();
  mesh.skip();
  Messages later;
  while (later.empty()) later = mesh.change();
  EXPECT_EQ(reader.apply(later.front()).status, Reader::Status::kLost);
}

TEST(MeshUpdates, ChangesMayComeBetweenThePartsOfTheWholeMesh) {
  std::size_t num_interleaved = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    ChangingMesh mesh(seed);
    for (int i = 0; i < 25; ++i) mesh.change();
    Reader reader;
    const auto indices = mesh.indices();  // as the mesh was when the subscriber came
    std::size_t next = 0;
    std::uint32_t part = 0;
    while (true) {
      const auto message = mesh.part(indices, next, ++part);
      ASSERT_EQ(reader.apply(message).status, Reader::Status::kApplied) << "seed " << seed;
      if (message.is_last != 0) break;
      EXPECT_FALSE(reader.hasWholeMesh());
      const auto changes = mesh.change();
      applyAll(reader, changes);
      num_interleaved += changes.size();
    }
    EXPECT_TRUE(reader.hasWholeMesh());
    EXPECT_TRUE(isSame(reader.blocks(), mesh.blocks())) << "seed " << seed;
  }
  EXPECT_GT(num_interleaved, 20U);
}

/// As roscpp delivers them: parts go to the subscriber at once, changes take a way round.
TEST(MeshUpdates, ChangesMayArriveAfterThePartsThatHoldThemAlready) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    ChangingMesh mesh(seed);
    for (int i = 0; i < 25; ++i) mesh.change();
    Messages late = mesh.change();
    Reader reader;
    const auto indices = mesh.indices();
    std::size_t next = 0;
    for (std::uint32_t part = 1;; ++part) {
      const auto message = mesh.part(indices, next, part);
      ASSERT_EQ(reader.apply(message).status, Reader::Status::kApplied) << "seed " << seed;
      if (message.is_last != 0) break;
      for (auto& change : mesh.change()) late.push_back(std::move(change));
    }
    for (const auto& change : late) {
      ASSERT_NE(reader.apply(change).status, Reader::Status::kLost) << "seed " << seed;
    }
    applyAll(reader, mesh.change());
    EXPECT_TRUE(isSame(reader.blocks(), mesh.blocks())) << "seed " << seed;
  }
}

TEST(MeshUpdates, AChangeLostBetweenThePartsIsNoticed) {
  int num_noticed = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    ChangingMesh mesh(seed);
    for (int i = 0; i < 25; ++i) mesh.change();
    Reader reader;
    const auto indices = mesh.indices();
    std::size_t next = 0;
    const auto first = mesh.part(indices, next, 1);
    if (first.is_last != 0) continue;
    reader.apply(first);
    while (mesh.change().empty()) continue;  // and nobody hears of it
    Messages later;
    while (later.empty()) later = mesh.change();
    EXPECT_EQ(reader.apply(later.front()).status, Reader::Status::kLost);
    EXPECT_FALSE(reader.hasWholeMesh());
    ++num_noticed;
  }
  EXPECT_GT(num_noticed, 10);
}

TEST(MeshUpdates, AClearedMapIsEmptyForWhoFollowsAndChangesFollow) {
  ChangingMesh mesh(11);
  Reader reader;
  applyAll(reader, mesh.all());
  for (int i = 0; i < 10; ++i) applyAll(reader, mesh.change());
  ASSERT_FALSE(reader.blocks().empty());
  EXPECT_TRUE(reader.apply(mesh.clear()).has_restarted);
  EXPECT_TRUE(reader.blocks().empty());
  EXPECT_TRUE(reader.hasWholeMesh());
  for (int i = 0; i < 10; ++i) applyAll(reader, mesh.change());
  EXPECT_TRUE(isSame(reader.blocks(), mesh.blocks()));
}

TEST(MeshUpdates, ANewMapReplacesTheOldOne) {
  ChangingMesh old_mesh(5);
  ChangingMesh new_mesh(6);
  for (int i = 0; i < 10; ++i) old_mesh.change();
  for (int i = 0; i < 3; ++i) new_mesh.change();
  Reader reader;
  applyAll(reader, old_mesh.all());
  const auto all = new_mesh.all();
  EXPECT_TRUE(reader.apply(all.front()).has_restarted);
  for (std::size_t i = 1; i < all.size(); ++i) reader.apply(all[i]);
  EXPECT_TRUE(isSame(reader.blocks(), new_mesh.blocks()));
}

TEST(MeshUpdates, MessagesAreOfBoundedSizeAndNameFrameAndStamp) {
  ChangingMesh mesh(7);
  std::size_t num_messages = 0;
  for (int i = 0; i < 50; ++i) mesh.change();
  for (const auto& message : mesh.all()) {
    const bool is_one_block = message.changed.size() == 1;  // a block is not divided
    EXPECT_TRUE(is_one_block || ros::serialization::serializationLength(message) <=
                                    MeshUpdateWriter::kMaxBytes + 200U);
    EXPECT_EQ(message.header.frame_id, "world");
    EXPECT_EQ(message.header.stamp.toNSec(), 12345678901U);
    EXPECT_FLOAT_EQ(message.block_size, 0.4F);
    EXPECT_EQ(message.part, ++num_messages);
  }
  EXPECT_GE(num_messages, 2U);
}

TEST(MeshUpdates, AnEmptyMapIsOneEmptyMessage) {
  const Messages messages = ChangingMesh(8).all();
  ASSERT_EQ(messages.size(), 1U);
  Reader reader;
  applyAll(reader, messages);
  EXPECT_TRUE(reader.hasWholeMesh());
}

TEST(MeshUpdates, ABrokenMessageChangesNothing) {
  ChangingMesh mesh(9);
  for (int i = 0; i < 10; ++i) mesh.change();
  Reader reader;
  applyAll(reader, mesh.all());
  Messages next;
  while (next.empty() || next.front().changed.empty()) next = mesh.change();
  const Reader::Blocks before = reader.blocks();
  msg::MeshUpdate broken = mesh.all().front();
  broken.changed.back().mesh.triangles[0] = 1000000;
  EXPECT_THROW(reader.apply(broken), InputError);
  broken = mesh.all().front();
  broken.removed = {1, 2};
  EXPECT_THROW(reader.apply(broken), InputError);
  EXPECT_TRUE(isSame(reader.blocks(), before));
  EXPECT_TRUE(reader.hasWholeMesh());
}

}  // namespace
}  // namespace tsg::ros_interface
