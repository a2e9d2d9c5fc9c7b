// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/mesh_archive.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstring>
#include <random>

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
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    archive.store({static_cast<int>(i), -5, 7}, makeRandomMesh(sizes[i], sizes[i] / 2));
  }
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    expectSameBits(archive.load({static_cast<int>(i), -5, 7}),
                   makeRandomMesh(sizes[i], sizes[i] / 2));
  }
  EXPECT_FALSE(archive.contains({9, -5, 7}));
  EXPECT_GT(archive.fileBytes(), 0U);
  EXPECT_EQ(archive.memoryBytes(), 0U);
}

TEST(MeshArchive, AMeshStoredAgainReplacesTheOneBefore) {
  MeshArchive archive;
  for (const std::size_t size : {300U, 20U, 40U, 1000U, 10U}) {
    archive.store({1, 2, 3}, makeRandomMesh(size, size));
    archive.store({4, 5, 6}, makeRandomMesh(50, 50));
    expectSameBits(archive.load({1, 2, 3}), makeRandomMesh(size, size));
    expectSameBits(archive.load({4, 5, 6}), makeRandomMesh(50, 50));
  }
}

TEST(MeshArchive, WhatTheFileCannotTakeStaysInMemory) {
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  MeshArchive archive;
  archive.store({0, 0, 0}, makeRandomMesh(1000, 500));
  const rlimit full{archive.fileBytes() + 100, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &full);
  archive.store({1, 0, 0}, makeRandomMesh(2000, 500));
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_GT(archive.memoryBytes(), 0U);
  expectSameBits(archive.load({0, 0, 0}), makeRandomMesh(1000, 500));
  expectSameBits(archive.load({1, 0, 0}), makeRandomMesh(2000, 500));
  archive.store({1, 0, 0}, makeRandomMesh(0, 0));
  expectSameBits(archive.load({1, 0, 0}), Mesh());
}

}  // namespace
}  // namespace tsg::mapping
