// SPDX-License-Identifier: BSD-3-Clause
// Maps that a running chain saves, loads and merges, and such that do not fit.
#include <gtest/gtest.h>
#include <std_srvs/Trigger.h>
#include <task_scene_graph/LoadMap.h>
#include <task_scene_graph/MergeMap.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>

#include "support.h"
#include "synthetic_robot.h"
#include "task_scene_graph/map/files.h"

namespace tsg::test {
namespace {

namespace fs = std::filesystem;

/// A chain in this process.
class Chain {
 public:
  /// @param map  to go on from; empty: none
  Chain(const fs::path& folder, const fs::path& output, const std::string& map) {
    setChainParameters(folder, output.string());
    for (const char* stage : {"/scene_graph", "/mesh_fusion"}) {
      ros::param::set(stage + std::string("/map"), map);
    }
  }
  void start() { startStages(loader_, robot_, tracks_, graphs_); }

  /// Each once the tracker has answered to it.
  void play(int first, int end, double start_s = 100.0) {
    for (int i = first; i < end; ++i) {
      const RobotMessages messages = makeMessages(i, start_s);
      robot_.publish(messages);
      ASSERT_TRUE(waitForTracks(tracks_, messages)) << i;
    }
  }
  static std_srvs::TriggerResponse save() {
    std_srvs::Trigger call;
    EXPECT_TRUE(ros::service::call("/scene_graph/save_map", call));
    EXPECT_TRUE(call.response.success) << call.response.message;
    return call.response;
  }
  static msg::LoadMapResponse loadMap(const fs::path& folder) {
    msg::LoadMap call;
    call.request.folder = folder.string();
    EXPECT_TRUE(ros::service::call("/scene_graph/load_map", call));
    return call.response;
  }
  static msg::MergeMapResponse mergeMap(const fs::path& folder) {
    msg::MergeMap call;
    call.request.folder = folder.string();
    EXPECT_TRUE(ros::service::call("/scene_graph/merge_map", call));
    return call.response;
  }
  static std::string reset() {
    std_srvs::Trigger call;
    EXPECT_TRUE(ros::service::call("/scene_graph/reset", call));
    return call.response.success ? "" : call.response.message;
  }
  bool waitForObjects(std::size_t count) {
    return waitUntil([&] {
      const auto all = graphs_.messages();
      return !all.empty() && all.back()->objects.size() == count;
    });
  }
  std::set<std::uint64_t> objectIds() const {
    std::set<std::uint64_t> ids;
    for (const auto& object : graphs_.messages().back()->objects) ids.insert(object.id);
    return ids;
  }

 private:
  Robot robot_;
  Recorder<msg::Tracks> tracks_{"tracks"};
  Recorder<msg::SceneGraph> graphs_{"scene_graph"};
  nodelet::Loader loader_{false};
};

std::map<std::string, std::string> readFolder(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream stream(entry.path(), std::ios::binary);
    files[entry.path().lexically_relative(folder).string()] = {
        std::istreambuf_iterator<char>(stream), {}};
  }
  return files;
}

/// Names of files that differ; what a run says of itself does not count.
std::set<std::string> compareFolders(const fs::path& a, const fs::path& b) {
  const auto left = readFolder(a);
  const auto right = readFolder(b);
  std::set<std::string> names;
  for (const auto* side : {&left, &right}) {
    for (const auto& [name, content] : *side) {
      const auto l = left.find(name);
      const auto r = right.find(name);
      if (l == left.end() || r == right.end() || l->second != r->second) names.insert(name);
    }
  }
  names.erase("settings.yaml");
  names.erase("map.json");      // has the checksums of both
  names.erase("floor_0.yaml");  // says the height of the floor as it was first measured
  return names;
}

class Maps : public ::testing::Test {
 protected:
  fs::path path(const std::string& name) const { return folder_.path() / name; }
  /// A saved map of these frames.
  void makeMap(const std::string& name, int first, int end, double start_s = 100.0) {
    Chain chain(folder_.path(), path(name), "");
    ASSERT_NO_FATAL_FAILURE(chain.start());
    ASSERT_NO_FATAL_FAILURE(chain.play(first, end, start_s));
    EXPECT_TRUE(chain.waitForObjects(2));
    Chain::save();
  }

  TemporaryFolder folder_;
};

TEST_F(Maps, ALiveFolderHoldsTheFilesOfAnOfflineOne) {
  ASSERT_NO_FATAL_FAILURE(makeMap("a", 0, 30));
  const auto files = readFolder(path("a"));
  for (const char* name :
       {"map.json", "scene_graph.json", "summary.json", "mesh.ply", "trajectory.txt",
        "settings.yaml", "floor_0.pgm", "state/primitives.bin", "state/free_space.bin"}) {
    EXPECT_EQ(files.count(name), 1U) << name;
  }
  EXPECT_EQ(computeSceneGraph(map::loadMap(path("a")).map).objects.size(), 2U);
}

TEST_F(Maps, LoadedAtTheStartAndSavedAgainItIsTheSameToTheByte) {
  ASSERT_NO_FATAL_FAILURE(makeMap("a", 0, 30));
  Chain chain(folder_.path(), path("again"), path("a").string());
  ASSERT_NO_FATAL_FAILURE(chain.start());
  EXPECT_TRUE(chain.waitForObjects(2));
  Chain::save();
  EXPECT_EQ(compareFolders(path("a"), path("again")), std::set<std::string>{});
}

TEST_F(Maps, LoadedWhileTheChainRunsAndSavedAgainItIsTheSameToTheByte) {
  ASSERT_NO_FATAL_FAILURE(makeMap("a", 0, 30));
  Chain chain(folder_.path(), path("again"), "");
  ASSERT_NO_FATAL_FAILURE(chain.start());
  ASSERT_NO_FATAL_FAILURE(chain.play(40, 45, 300.0));
  const auto loaded = Chain::loadMap(path("a"));
  ASSERT_TRUE(loaded.success) << loaded.message;
  EXPECT_TRUE(chain.waitForObjects(2));
  Chain::save();
  EXPECT_EQ(compareFolders(path("a"), path("again")), std::set<std::string>{});
}

TEST_F(Maps, MappingGoesOnAfterLoading) {
  ASSERT_NO_FATAL_FAILURE(makeMap("a", 0, 20));
  Chain chain(folder_.path(), path("b"), path("a").string());
  ASSERT_NO_FATAL_FAILURE(chain.start());
  EXPECT_TRUE(chain.waitForObjects(2));
  const auto before = chain.objectIds();
  ASSERT_NO_FATAL_FAILURE(chain.play(20, 60, 300.0));
  Chain::save();
  EXPECT_TRUE(chain.waitForObjects(2));  // what was seen again is the same thing
  EXPECT_EQ(chain.objectIds(), before);
  const map::Map map = map::loadMap(path("b")).map;
  EXPECT_GT(map.primitives().size(), 2U);
  EXPECT_EQ(map.trajectory()->size(), 60U);
  EXPECT_GT(map.meshBlocks().size(), map::loadMap(path("a")).map.meshBlocks().size());
}

TEST_F(Maps, WhatDoesNotFitIsNamedAndTheMapStays) {
  ASSERT_NO_FATAL_FAILURE(makeMap("a", 0, 20));
  Chain chain(folder_.path(), path("now"), "");
  ASSERT_NO_FATAL_FAILURE(chain.start());
  ASSERT_NO_FATAL_FAILURE(chain.play(0, 20));
  EXPECT_TRUE(chain.waitForObjects(2));
  const auto ids = chain.objectIds();
  Chain::save();
  const auto before = readFolder(path("now")).at("state/primitives.bin");
  const auto refuse = [&](const std::string& key, const nlohmann::json& value) {
    fs::remove_all(path("bad"));
    fs::copy(path("a"), path("bad"), fs::copy_options::recursive);
    auto manifest = nlohmann::json::parse(std::ifstream(path("bad") / "map.json"));
    manifest[key] = value;
    std::ofstream(path("bad") / "map.json") << manifest;
    const auto answer = Chain::loadMap(path("bad"));
    EXPECT_FALSE(answer.success) << key;
    EXPECT_NE(answer.message.find(path("bad").string()), std::string::npos) << answer.message;
    return answer.message;
  };
  EXPECT_NE(refuse("version", 7).find("version 7, expected 1"), std::string::npos);
  EXPECT_NE(refuse("frame", "moon").find("'moon', expected 'world'"), std::string::npos);
  EXPECT_NE(refuse("embedding_size", 512).find("512, expected 4"), std::string::npos);
  fs::remove_all(path("bad"));
  fs::copy(path("a"), path("bad"), fs::copy_options::recursive);
  std::ofstream(path("bad") / "state/free_space.bin") << "damaged";
  const auto damaged = Chain::loadMap(path("bad"));
  EXPECT_FALSE(damaged.success);
  EXPECT_NE(damaged.message.find("free_space.bin' is damaged"), std::string::npos)
      << damaged.message;
  EXPECT_FALSE(Chain::loadMap(path("nowhere")).success);
  EXPECT_FALSE(Chain::mergeMap(path("nowhere")).success);
  EXPECT_EQ(chain.objectIds(), ids);
  Chain::save();
  EXPECT_EQ(readFolder(path("now")).at("state/primitives.bin"), before);
}

TEST_F(Maps, ASavedMapIsMergedIntoTheRunningOne) {
  ASSERT_NO_FATAL_FAILURE(makeMap("a", 0, 20));
  Chain chain(folder_.path(), path("both"), "");
  ASSERT_NO_FATAL_FAILURE(chain.start());
  ASSERT_NO_FATAL_FAILURE(chain.play(20, 40, 300.0));
  EXPECT_TRUE(chain.waitForObjects(2));
  const auto merged = Chain::mergeMap(path("a"));
  ASSERT_TRUE(merged.success) << merged.message;
  EXPECT_TRUE(chain.waitForObjects(2));
  ASSERT_NO_FATAL_FAILURE(chain.play(40, 44, 300.0));  // it goes on
  Chain::save();
  const map::Map map = map::loadMap(path("both")).map;
  ASSERT_EQ(map.sources().size(), 1U);
  EXPECT_EQ(map.sources().front().name, path("a").string());
  EXPECT_GE(map.primitives().size(), 4U);
  EXPECT_GE(map.trajectory()->size(), 40U);
}

TEST_F(Maps, AResetForgetsTheMapThatWasLoaded) {
  ASSERT_NO_FATAL_FAILURE(makeMap("a", 0, 20));
  Chain chain(folder_.path(), path("b"), path("a").string());
  ASSERT_NO_FATAL_FAILURE(chain.start());
  EXPECT_TRUE(chain.waitForObjects(2));
  EXPECT_EQ(Chain::reset(), "");
  EXPECT_TRUE(chain.waitForObjects(0));
}

}  // namespace
}  // namespace tsg::test

int main(int argc, char** argv) { return tsg::test::runRosTests(argc, argv, "maps_test"); }
