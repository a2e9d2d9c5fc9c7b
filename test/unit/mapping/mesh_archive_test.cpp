// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/mesh_archive.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <csignal>
#include <cstring>
#include <random>
#include <thread>

namespace tsg::mapping {
namespace {

Mesh makeRandomMesh(std::size_t vertices, std::size_t triangles) {
  std::mt19937 random(7);
  std::uniform_int_distribution<std::uint32_t> any;
  Mesh mesh;
  for (std::size_t i = 0; i < vertices; ++i) {
    Eigen::Vector3f p;
    for (int axis = 0; axis < 3; ++axis) {
      const std::uint32_t bits = any(random);  // any float there is, NaN among them
      std::memcpy(&p[axis], &bits, sizeof(bits));
    }
    mesh.vertices.push_back(p);
    mesh.colors.push_back({static_cast<std::uint8_t>(i), 2, static_cast<std::uint8_t>(3 * i)});
  }
  for (std::size_t i = 0; i < triangles; ++i) {
    mesh.triangles.push_back({any(random), any(random), any(random)});
  }
  return mesh;
}

void expectSameBits(const Mesh& a, const Mesh& b) {
  ASSERT_EQ(a.vertices.size(), b.vertices.size());
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.colors, b.colors);
  const std::size_t bytes = a.vertices.size() * sizeof(Eigen::Vector3f);
  EXPECT_TRUE(bytes == 0 || std::memcmp(a.vertices.data(), b.vertices.data(), bytes) == 0);
}

TEST(MeshArchive, GivesBackEveryBit) {
  MeshArchive archive;
  const std::vector<std::size_t> sizes{0, 1, 100, 70000};
  std::vector<MeshArchive::RecordPtr> records;
  for (const auto size : sizes) records.push_back(archive.store(makeRandomMesh(size, size / 2)));
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    expectSameBits(records[i]->load(), makeRandomMesh(sizes[i], sizes[i] / 2));
  }
  EXPECT_GT(archive.fileBytes(), 0U);
  EXPECT_EQ(archive.memoryBytes(), 0U);
}

TEST(MeshArchive, WhatIsStoredLaterNeverChangesARecordThatSomebodyHolds) {
  MeshArchive archive;
  const auto held = archive.store(makeRandomMesh(300, 300));
  MeshArchive::RecordPtr replaced;
  for (const std::size_t size : {300U, 20U, 40U, 1000U, 10U, 300U, 299U}) {
    replaced = archive.store(makeRandomMesh(size, size));
    expectSameBits(replaced->load(), makeRandomMesh(size, size));
    expectSameBits(held->load(), makeRandomMesh(300, 300));
  }
}

TEST(MeshArchive, RecordsThatAreReplacedOverAndOverDoNotMakeTheFileGrow) {
  MeshArchive archive;
  std::mt19937 random(3);
  std::uniform_int_distribution<std::size_t> size(1, 400);
  std::vector<MeshArchive::RecordPtr> records(50);
  std::size_t after_first_rounds = 0;
  for (int round = 0; round < 200; ++round) {
    for (auto& record : records) {
      const std::size_t n = size(random);
      record = archive.store(makeRandomMesh(n, n));
    }
    if (round == 19) after_first_rounds = archive.fileBytes();
  }
  EXPECT_LT(archive.fileBytes(),
            2 * after_first_rounds);  // all of them took 200 / 20 times as much
}

TEST(MeshArchive, PlacesOfTheFileAreAtMostASixthLargerThanWhatTheyHold) {
  std::size_t stored = 0;
  for (const std::size_t n : {10U, 77U, 500U, 3001U}) {
    MeshArchive archive;
    const auto record = archive.store(makeRandomMesh(n, 0));  // random: it does not compress
    stored = 15 * n;
    EXPECT_LT(static_cast<double>(archive.fileBytes()), 1.17 * static_cast<double>(stored) + 40.0);
    EXPECT_GT(archive.fileBytes(), stored / 2);
  }
}

TEST(MeshArchive, RecordsOutliveTheArchive) {
  auto archive = std::make_unique<MeshArchive>();
  const auto record = archive->store(makeRandomMesh(100, 50));
  archive.reset();
  expectSameBits(record->load(), makeRandomMesh(100, 50));
}

TEST(MeshArchive, ManyThreadsLoadWhileOneStores) {
  MeshArchive archive;
  std::vector<MeshArchive::RecordPtr> records;
  for (std::size_t n = 1; n <= 50; ++n) records.push_back(archive.store(makeRandomMesh(n, n)));
  std::vector<std::thread> readers;
  std::atomic<int> mistakes{0};
  for (int i = 0; i < 3; ++i) {
    readers.emplace_back([&] {
      for (std::size_t n = 1; n <= 50; ++n) {
        if (records[n - 1]->load().triangles != makeRandomMesh(n, n).triangles) ++mistakes;
      }
    });
  }
  for (std::size_t n = 50; n >= 1; --n) archive.store(makeRandomMesh(n, n));  // free again at once
  for (auto& reader : readers) reader.join();
  EXPECT_EQ(mistakes, 0);
}

TEST(MeshArchive, WhatTheFileCannotTakeStaysInMemory) {
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  MeshArchive archive;
  const auto in_file = archive.store(makeRandomMesh(1000, 500));
  const rlimit full{archive.fileBytes() + 100, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &full);
  auto in_memory = archive.store(makeRandomMesh(2000, 500));
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_GT(archive.memoryBytes(), 0U);
  expectSameBits(in_file->load(), makeRandomMesh(1000, 500));
  expectSameBits(in_memory->load(), makeRandomMesh(2000, 500));
  in_memory.reset();
  EXPECT_EQ(archive.memoryBytes(), 0U);
  expectSameBits(archive.store(Mesh())->load(), Mesh());
}

}  // namespace
}  // namespace tsg::mapping
