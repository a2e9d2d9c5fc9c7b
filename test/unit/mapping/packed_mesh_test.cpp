// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/packed_mesh.h"

#include <gtest/gtest.h>

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

TEST(PackedMesh, GivesBackEveryBit) {
  for (const std::size_t size : {0U, 1U, 100U, 70000U}) {
    const Mesh mesh = makeRandomMesh(size, size / 2);
    const Mesh unpacked = PackedMesh(mesh).unpack();
    ASSERT_EQ(unpacked.vertices.size(), size);
    ASSERT_EQ(unpacked.triangles, mesh.triangles);
    ASSERT_EQ(unpacked.colors, mesh.colors);
    EXPECT_TRUE(size == 0 || std::memcmp(unpacked.vertices.data(), mesh.vertices.data(),
                                         size * sizeof(Eigen::Vector3f)) == 0);
  }
}

}  // namespace
}  // namespace tsg::mapping
