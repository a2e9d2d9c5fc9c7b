// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/map/files.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <set>

#include "../scene_graph/random_world.h"
#include "support.h"
#include "task_scene_graph/mapping/ply.h"

namespace tsg::map {
namespace {

namespace fs = std::filesystem;

std::string readFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::set<std::string> listFolder(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename());
  return names;
}

std::set<std::string> listNames(const std::vector<WrittenFile>& files) {
  std::set<std::string> names;
  for (const auto& file : files) names.insert(file.name);
  return names;
}

/// One object of one triangle, and a background mesh that has it and a far one.
Map makeSmallMap() {
  Map map("odom");
  scene_graph::TaskList tasks;
  tasks.names = {"wash"};
  tasks.embeddings = Embedding::Unit(3, 0).transpose();
  map.setTasks(tasks, tasks);
  auto primitive = std::make_shared<ObjectPrimitive>();
  primitive->id = {4};
  primitive->box = makeAabb({0, 0, 0}, {1, 1, 1});
  primitive->embedding = Embedding::Unit(3, 0);
  primitive->mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  primitive->mesh.colors.resize(3);
  primitive->mesh.triangles = {{0, 1, 2}};
  primitive->last_seen = Stamp{5};
  map.addPrimitives({primitive});
  map.setClusters({{{7}, 1, {{4}}}}, {});
  Mesh far = primitive->mesh;
  for (auto& vertex : far.vertices) vertex.x() += 10.0F;
  map.setMesh(0.05, {{{0, 0, 0}, std::make_shared<const Mesh>(primitive->mesh)},
                     {{9, 0, 0}, std::make_shared<const Mesh>(far)}});
  return map;
}

TEST(MapFiles, AMapIsWrittenWithAllThatItHolds) {
  const test::TemporaryFolder folder;
  Map map = makeSmallMap();
  Trajectory trajectory;
  trajectory.add({1'000'000'007}, Pose::Identity());
  map.setTrajectory(std::make_shared<const Trajectory>(trajectory));
  MapSettings settings;
  settings.stages = {{"scene_graph", {{"object_alpha", "0.5", "a file"}}}};
  settings.record = {{"program", "test", ""}};
  map.setSettings(settings);
  const auto files = writeMap(folder.path() / "new/map", map);
  const std::set<std::string> expected = {"scene_graph.json", "summary.json",  "trajectory.txt",
                                          "mesh.ply",         "settings.yaml", "state",
                                          "map.json"};
  EXPECT_EQ(listNames(files), expected);
  EXPECT_EQ(listFolder(folder.path() / "new/map"), expected);
  const auto settings_text = readFile(folder.path() / "new/map/settings.yaml");
  EXPECT_NE(settings_text.find("object_alpha: 0.5"), std::string::npos) << settings_text;
  EXPECT_NE(readFile(folder.path() / "new/map/summary.json").find("odom"), std::string::npos);
}

TEST(MapFiles, WhatAMapDoesNotHoldHasNoFile) {
  const test::TemporaryFolder folder;
  const std::set<std::string> expected = {"scene_graph.json", "summary.json", "state", "map.json"};
  EXPECT_EQ(listNames(writeMap(folder.path(), Map())), expected);
  EXPECT_EQ(listFolder(folder.path()), expected);
}

TEST(MapFiles, VerticesOfTheMeshHaveTheIdOfTheirObject) {
  const test::TemporaryFolder folder;
  writeMap(folder.path(), makeSmallMap());
  const std::string ply = readFile(folder.path() / "mesh.ply");
  EXPECT_NE(ply.find("comment frame odom"), std::string::npos);
  const std::string header_end = "end_header\n";
  const std::size_t body = ply.find(header_end) + header_end.size();
  constexpr std::size_t kVertexBytes = 19;  // 3 floats, 3 colours, the id
  std::multiset<std::int32_t> ids;
  for (std::size_t i = 0; i < 6; ++i) {
    std::int32_t id = 0;
    std::memcpy(&id, ply.data() + body + i * kVertexBytes + 15, sizeof(id));
    ids.insert(id);
  }
  EXPECT_EQ(ids, (std::multiset<std::int32_t>{0, 0, 0, 7, 7, 7}));
}

TEST(MapFiles, ATrajectoryIsReadAsItWasWritten) {
  const test::TemporaryFolder folder;
  Map map = makeSmallMap();
  Trajectory trajectory;
  Pose pose = Pose::Identity();
  pose.translation() = Eigen::Vector3d(500000.123456789, 1.0 / 3.0, -2e-9);
  pose.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  trajectory.add({1'600'000'000'000'000'001}, pose);
  trajectory.add({1'600'000'000'100'000'000}, Pose::Identity());
  map.setTrajectory(std::make_shared<const Trajectory>(trajectory));
  writeMap(folder.path(), map);
  const Trajectory read = loadTumTrajectory((folder.path() / "trajectory.txt").string());
  ASSERT_EQ(read.size(), 2U);
  const auto first = read.poses().begin();
  EXPECT_EQ(first->first, 1'600'000'000'000'000'001);
  EXPECT_EQ(first->second.translation(), pose.translation());
  EXPECT_TRUE(first->second.linear().isApprox(pose.linear(), 1e-15));
}

TEST(MapFiles, AFolderThatCannotBeMadeIsNamed) {
  const test::TemporaryFolder folder;
  std::ofstream(folder.path() / "file") << "x";
  try {
    writeMap(folder.path() / "file/map", makeSmallMap());
    FAIL();
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find((folder.path() / "file/map").string()), std::string::npos)
        << e.what();
  }
}

}  // namespace
}  // namespace tsg::map
