// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/ply.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <sstream>

#include "support.h"

namespace tsg::mapping {
namespace {

Mesh makeMesh() {
  Mesh mesh;
  mesh.vertices = {{0.0F, 1.5F, -2.25F}, {1, 0, 0}, {0, 1, 0}};
  mesh.colors = {{1, 2, 3}, {255, 0, 128}, {7, 8, 9}};
  mesh.triangles = {{0, 1, 2}, {2, 1, 0}};
  return mesh;
}

std::string readFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

template <typename T>
T take(const std::string& bytes, std::size_t& position) {
  T value{};
  std::memcpy(&value, bytes.data() + position, sizeof(T));
  position += sizeof(T);
  return value;
}

TEST(Ply, BytesAreThoseOfTheMesh) {
  const test::TemporaryFolder folder;
  const Mesh mesh = makeMesh();
  writePly(folder.path() / "mesh.ply", mesh, {4, 5, 6});
  const std::string bytes = readFile(folder.path() / "mesh.ply");
  EXPECT_NE(bytes.find("format binary_little_endian 1.0\nelement vertex 3\n"), std::string::npos);
  EXPECT_NE(bytes.find("property int object_id\nelement face 2\n"), std::string::npos);
  std::size_t position = bytes.find("end_header\n") + 11;
  for (std::size_t i = 0; i < 3; ++i) {
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_EQ(take<float>(bytes, position), mesh.vertices[i][axis]);
    for (const auto channel : mesh.colors[i])
      EXPECT_EQ(take<std::uint8_t>(bytes, position), channel);
    EXPECT_EQ(take<std::int32_t>(bytes, position), static_cast<std::int32_t>(i) + 4);
  }
  for (const auto& triangle : mesh.triangles) {
    EXPECT_EQ(take<std::uint8_t>(bytes, position), 3);
    for (const auto vertex : triangle) EXPECT_EQ(take<std::uint32_t>(bytes, position), vertex);
  }
  EXPECT_EQ(position, bytes.size());
}

TEST(Ply, EmptyMeshIsAValidFile) {
  const test::TemporaryFolder folder;
  writePly(folder.path() / "mesh.ply", Mesh{});
  const std::string text = readFile(folder.path() / "mesh.ply");
  EXPECT_EQ(text.substr(text.size() - 11), "end_header\n");
  EXPECT_NE(text.find("element face 0\n"), std::string::npos);
}

TEST(Ply, ReplacesAFileAndLeavesNoOther) {
  const test::TemporaryFolder folder;
  writePly(folder.path() / "mesh.ply", makeMesh());
  writePly(folder.path() / "mesh.ply", Mesh{});
  const auto begin = std::filesystem::directory_iterator(folder.path());
  EXPECT_EQ(std::distance(begin, std::filesystem::directory_iterator()), 1);
  EXPECT_NE(readFile(folder.path() / "mesh.ply").find("element vertex 0\n"), std::string::npos);
}

TEST(Ply, ErrorNamesTheFile) {
  const test::TemporaryFolder folder;
  std::ofstream(folder.path() / "no_folder") << "a file";
  const std::string path = (folder.path() / "no_folder" / "mesh.ply").string();
  try {
    writePly(path, makeMesh());
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find(path), std::string::npos) << e.what();
  }
}

TEST(Ply, NeedsOneColorAndOneIdPerVertex) {
  const test::TemporaryFolder folder;
  Mesh mesh = makeMesh();
  EXPECT_THROW(writePly(folder.path() / "mesh.ply", mesh, {1}), std::invalid_argument);
  mesh.colors.pop_back();
  EXPECT_THROW(writePly(folder.path() / "mesh.ply", mesh), std::invalid_argument);
}

TEST(Ply, HeaderNamesTheFrameInAComment) {
  const test::TemporaryFolder folder;
  writePly(folder.path() / "mesh.ply", makeMesh(), {4, 5, 6}, "odom");
  std::ifstream file(folder.path() / "mesh.ply", std::ios::binary);
  std::string line;
  for (int i = 0; i < 3; ++i) std::getline(file, line);
  EXPECT_EQ(line, "comment frame odom");
}

}  // namespace
}  // namespace tsg::mapping
