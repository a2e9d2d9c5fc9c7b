// SPDX-License-Identifier: BSD-3-Clause
// A map that was saved is read back, and mapping goes on from it.
#include <gtest/gtest.h>
#include <zlib.h>

#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "../scene_graph/random_world.h"
#include "support.h"
#include "task_scene_graph/core/binary.h"
#include "task_scene_graph/map/files.h"
#include "walk.h"

namespace tsg::map {
namespace {

namespace fs = std::filesystem;
using test::compareObjects;
using test::makePipeline;
using test::makeWalkMap;
using test::readFolder;

constexpr std::size_t kHeadBytes = 20;  // of a file of the state: kind and version

std::string errorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::exception& e) {
    return e.what();
  }
  return "";
}

/// Names of the files whose content differs.
std::set<std::string> compareFolders(const fs::path& a, const fs::path& b) {
  const auto left = readFolder(a);
  const auto right = readFolder(b);
  std::set<std::string> different;
  for (const auto& [name, content] : left) {
    if (right.count(name) == 0 || right.at(name) != content) different.insert(name);
  }
  for (const auto& [name, content] : right) {
    if (left.count(name) == 0) different.insert(name);
  }
  return different;
}

class SavedWalk : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<test::TemporaryFolder>();
    map_ = makeWalkMap(0, test::kWalkFrames, true);
    writeMap(saved(), *map_);
  }
  static void TearDownTestSuite() {
    folder_.reset();
    map_.reset();
  }
  static fs::path saved() { return folder_->path() / "saved"; }
  /// A copy of the saved map that a test may spoil.
  fs::path copy() const {
    fs::copy(saved(), own_.path() / "map", fs::copy_options::recursive);
    return own_.path() / "map";
  }

  static std::unique_ptr<test::TemporaryFolder> folder_;
  static MapPtr map_;
  test::TemporaryFolder own_;
};

std::unique_ptr<test::TemporaryFolder> SavedWalk::folder_;
MapPtr SavedWalk::map_;

TEST_F(SavedWalk, HasAllTheFilesThatAMapHas) {
  std::set<std::string> names;
  for (const auto& [name, content] : readFolder(saved())) names.insert(name);
  for (const char* name :
       {"map.json", "scene_graph.json", "summary.json", "mesh.ply", "trajectory.txt", "map.bt",
        "map.ot", "floor_0.pgm", "floor_0.yaml", "state/tasks.bin", "state/primitives.bin",
        "state/places.bin", "state/clusters.bin", "state/mesh_blocks.bin", "state/trajectory.bin",
        "state/free_space.bin"}) {
    EXPECT_EQ(names.count(name), 1U) << name;
  }
  const auto graph = computeSceneGraph(*map_);
  ASSERT_EQ(graph.objects.size(), 2U);
  for (const auto& object : graph.objects) {
    EXPECT_EQ(names.count("thumbnails/O" + std::to_string(object.id.value) + ".png"), 1U);
  }
}

TEST_F(SavedWalk, SavedAgainAfterLoadingItIsTheSameToTheByte) {
  LoadedMap loaded = loadMap(saved());
  EXPECT_TRUE(loaded.notes.empty());
  loaded.map.setOccupancy(readOccupancy(saved(), {}));
  writeMap(own_.path() / "again", loaded.map);
  EXPECT_EQ(compareFolders(saved(), own_.path() / "again"), std::set<std::string>{});
}

TEST_F(SavedWalk, AChainThatWasRestoredFromItSavesTheSameToTheByte) {
  LoadedMap loaded = loadMap(saved());
  loaded.map.setOccupancy(readOccupancy(saved(), {}));
  const auto pipeline = makePipeline(true);
  pipeline->restore(loaded.map);
  writeMap(own_.path() / "again", *pipeline->finish());
  EXPECT_EQ(compareFolders(saved(), own_.path() / "again"), std::set<std::string>{});
}

TEST_F(SavedWalk, GoingOnAfterLoadingGivesTheObjectsOfOneRun) {
  const int half = test::kWalkFrames / 2;
  writeMap(own_.path() / "half", *makeWalkMap(0, half));
  const auto pipeline = makePipeline();
  pipeline->restore(loadMap(own_.path() / "half").map);
  test::walk(*pipeline, half, test::kWalkFrames);
  const MapPtr went_on = pipeline->finish();
  EXPECT_EQ(compareObjects(computeSceneGraph(*went_on), computeSceneGraph(*map_), 0.7), "");
  EXPECT_EQ(went_on->trajectory()->size(), map_->trajectory()->size());
  std::set<std::uint64_t> ids;
  for (const auto& primitive : went_on->primitives()) ids.insert(primitive->id.value);
  EXPECT_EQ(ids.size(), went_on->primitives().size());
  const double places = static_cast<double>(went_on->places()->places.size());
  EXPECT_NEAR(places, static_cast<double>(map_->places()->places.size()), 0.2 * places);
}

TEST_F(SavedWalk, PlacesKeepTheirIdsAfterLoading) {
  const auto pipeline = makePipeline();
  pipeline->restore(loadMap(saved()).map);
  const MapPtr restored = pipeline->finish();
  ASSERT_EQ(restored->places()->places.size(), map_->places()->places.size());
  for (std::size_t i = 0; i < map_->places()->places.size(); ++i) {
    const Place& before = map_->places()->places[i];
    const Place& after = restored->places()->places[i];
    EXPECT_EQ(before.id, after.id);
    EXPECT_EQ(before.position_m, after.position_m);
    EXPECT_EQ(before.embedding, after.embedding);
  }
}

TEST_F(SavedWalk, WhatDoesNotFitIsNamedWithWhatWasExpected) {
  const auto error = [&](const MapUse& use) { return errorOf([&] { loadMap(saved(), use); }); };
  MapUse use;
  use.world_frame = "map";
  EXPECT_NE(error(use).find("frame 'odom', expected 'map'"), std::string::npos) << error(use);
  use = {};
  use.embedding_size = 512;
  EXPECT_NE(error(use).find("size 4, expected 512"), std::string::npos) << error(use);
  use = {};
  use.mesh_voxel_size_m = 0.031;
  EXPECT_NE(error(use).find("expected 0.031"), std::string::npos) << error(use);
  use = {};
  use.free_space_voxel_size_m = 0.2;
  EXPECT_NE(error(use).find("0.1, expected 0.2"), std::string::npos) << error(use);
  for (const MapUse& used : {use}) EXPECT_NE(error(used).find(saved().string()), std::string::npos);
  use = {"odom", "", 4, 0.0, 0.1};
  EXPECT_EQ(error(use), "");
}

TEST_F(SavedWalk, AnotherModelSetIsRefused) {
  Map map = *map_;
  MapSettings settings = map.settings();
  settings.model_set = "vit-l-14";
  map.setSettings(settings);
  writeMap(own_.path() / "map", map);
  MapUse use;
  use.model_set = "vit-b-32";
  const std::string error = errorOf([&] { loadMap(own_.path() / "map", use); });
  EXPECT_NE(error.find("'vit-l-14', expected 'vit-b-32'"), std::string::npos) << error;
  EXPECT_EQ(loadMap(own_.path() / "map").map.settings().model_set, "vit-l-14");
}

TEST_F(SavedWalk, EveryDamagedByteOfTheStateIsFound) {
  const fs::path folder = copy();
  for (const char* name : {"state/tasks.bin", "state/primitives.bin", "state/places.bin",
                           "state/clusters.bin", "state/mesh_blocks.bin", "state/free_space.bin"}) {
    const std::string whole = readFolder(folder).at(name);
    std::string damaged = whole;
    damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 1);
    std::ofstream(folder / name, std::ios::binary) << damaged;
    const std::string error = errorOf([&] { loadMap(folder); });
    EXPECT_NE(error.find(name), std::string::npos) << error;
    std::ofstream(folder / name, std::ios::binary) << whole;
  }
  EXPECT_EQ(errorOf([&] { loadMap(folder); }), "");
}

/// What a file of the state holds, and back; see core/binary.h.
std::string unpack(const std::string& file) {
  std::string content(std::size_t{1} << 26, '\0');
  uLongf size = content.size();
  EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(content.data()), &size,
                       reinterpret_cast<const Bytef*>(file.data()) + kHeadBytes,
                       file.size() - kHeadBytes),
            Z_OK);
  content.resize(size);
  return content;
}

std::string pack(const std::string& head, const std::string& content) {
  std::string packed(compressBound(content.size()), '\0');
  uLongf size = packed.size();
  compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
            reinterpret_cast<const Bytef*>(content.data()), content.size(), Z_BEST_SPEED);
  packed.resize(size);
  return head + packed;
}

TEST_F(SavedWalk, StateThatSomebodyElseWroteIsReadOrRefusedWhateverItIs) {
  const fs::path folder = copy();
  std::mt19937 random(17);
  int num_refused = 0;
  for (const char* name :
       {"state/tasks.bin", "state/primitives.bin", "state/places.bin", "state/clusters.bin",
        "state/mesh_blocks.bin", "state/trajectory.bin", "state/free_space.bin"}) {
    const std::string whole = readFolder(folder).at(name);
    const std::string content = unpack(whole);
    for (int round = 0; round < 60; ++round) {
      std::string changed = content;
      const std::size_t reach =
          round % 2 == 0 ? changed.size() : std::min<std::size_t>(200, changed.size());
      for (int k = 0; k < 1 + round % 4; ++k) {
        changed[random() % reach] = static_cast<char>(round % 3 == 0 ? 0xFF : random());
      }
      if (round % 10 == 9) changed.resize(random() % changed.size());
      std::ofstream(folder / name, std::ios::binary) << pack(whole.substr(0, kHeadBytes), changed);
      auto manifest = nlohmann::json::parse(readFolder(folder).at("map.json"));
      manifest["files"][name] = {{"bytes", fs::file_size(folder / name)},
                                 {"crc32", computeCrc32(folder / name)}};
      std::ofstream(folder / "map.json") << manifest.dump();
      num_refused += errorOf([&] { loadMap(folder); }).empty() ? 0 : 1;
    }
    std::ofstream(folder / name, std::ios::binary) << whole;
    fs::copy_file(saved() / "map.json", folder / "map.json", fs::copy_options::overwrite_existing);
  }
  EXPECT_GT(num_refused, 50);
  EXPECT_EQ(errorOf([&] { loadMap(folder); }), "");
}

TEST_F(SavedWalk, AMapWithoutOneOfItsPartsIsRefused) {
  const fs::path folder = copy();
  fs::remove(folder / "state/primitives.bin");
  EXPECT_NE(errorOf([&] { loadMap(folder); }).find("primitives.bin' is not there"),
            std::string::npos);
}

TEST_F(SavedWalk, FilesForPeopleMayBeMissing) {
  const fs::path folder = copy();
  for (const char* name : {"summary.json", "mesh.ply", "trajectory.txt", "scene_graph.json"}) {
    fs::remove(folder / name);
  }
  EXPECT_EQ(loadMap(folder).map.primitives().size(), map_->primitives().size());
}

/// The saved scene graph as JSON, edited, in a copy of the map.
class EditedWalk : public SavedWalk {
 protected:
  EditedWalk() : folder_of_map_(copy()) {
    graph_ = nlohmann::json::parse(readFolder(folder_of_map_).at("scene_graph.json"));
  }
  LoadedMap load() {
    std::ofstream(folder_of_map_ / "scene_graph.json") << graph_.dump();
    return loadMap(folder_of_map_);
  }
  std::size_t findPrimitive() const {
    for (std::size_t i = 0; i < graph_["nodes"].size(); ++i) {
      if (graph_["nodes"][i]["layer"] == 1) return i;
    }
    return 0;
  }
  static PrimitiveId toId(const nlohmann::json& node) {
    return {node["id"].get<std::uint64_t>() & 0xFFFFFFFFFFFFFFU};
  }

  fs::path folder_of_map_;
  nlohmann::json graph_;
};

TEST_F(EditedWalk, AFileThatWasOnlyRewrittenChangesNothing) {
  const LoadedMap loaded = load();
  ASSERT_FALSE(loaded.notes.empty());
  EXPECT_NE(loaded.notes.front().find("as they were"), std::string::npos) << loaded.notes.front();
  writeMap(own_.path() / "again", loaded.map);
  const auto different = compareFolders(saved(), own_.path() / "again");
  EXPECT_EQ(different.count("state/primitives.bin"), 0U);
  EXPECT_EQ(different.count("scene_graph.json"), 0U);
}

TEST_F(EditedWalk, APrimitiveThatWasTakenOutIsGone) {
  const std::size_t node = findPrimitive();
  const PrimitiveId id = toId(graph_["nodes"][node]);
  graph_["nodes"].erase(node);
  const LoadedMap loaded = load();
  EXPECT_EQ(loaded.map.findPrimitive(id), nullptr);
  EXPECT_EQ(loaded.map.primitives().size() + 1, map_->primitives().size());
  EXPECT_NE(loaded.notes.front().find("erased primitives s" + std::to_string(id.value)),
            std::string::npos)
      << loaded.notes.front();
}

TEST_F(EditedWalk, APrimitiveThatWasMovedIsMovedWithItsMesh) {
  auto& attributes = graph_["nodes"][findPrimitive()]["attributes"];
  const PrimitiveId id = toId(graph_["nodes"][findPrimitive()]);
  auto& center = attributes["bounding_box"]["world_P_center"];
  center[0] = center[0].get<double>() + 1.5;
  const LoadedMap loaded = load();
  const auto before = map_->findPrimitive(id);
  const auto after = loaded.map.findPrimitive(id);
  ASSERT_NE(after, nullptr);
  const Eigen::Vector3d step(1.5, 0, 0);
  EXPECT_TRUE(after->box.center().isApprox(before->box.center() + step, 1e-9));
  EXPECT_TRUE(after->mesh.vertices.front().isApprox(
      before->mesh.vertices.front() + step.cast<float>(), 1e-5F));
}

TEST_F(EditedWalk, APrimitiveThatWasPutInIsThere) {
  nlohmann::json node = graph_["nodes"][findPrimitive()];
  node["id"] = (std::uint64_t{'s'} << 56) + 4711;
  graph_["nodes"].push_back(node);
  const LoadedMap loaded = load();
  ASSERT_NE(loaded.map.findPrimitive({4711}), nullptr);
  EXPECT_EQ(loaded.map.findPrimitive({4711})->embedding.size(), test::kWalkSize);
}

TEST_F(EditedWalk, ObjectsThatWereTakenOutComeBackAndThatIsSaid) {
  auto& nodes = graph_["nodes"];
  for (std::size_t i = nodes.size(); i-- > 0;) {
    if (nodes[i]["layer"] == 2) nodes.erase(i);
  }
  const LoadedMap loaded = load();
  EXPECT_EQ(computeSceneGraph(loaded.map).objects.size(), 2U);
  EXPECT_NE(loaded.notes.at(1).find("objects, places and regions follow"), std::string::npos);
}

TEST(SavedMap, IdsOfObjectsAndRegionsOutliveLoading) {
  scene_graph::RandomWorld world(11);
  scene_graph::SceneGraphConfig config;
  config.object_alpha = 0.1;
  scene_graph::SceneGraphBuilder builder(config, "odom");
  builder.setObjectTasks(world.tasks());
  builder.setPlaceTasks(world.tasks());
  builder.addPrimitives(world.makePrimitives(40, 6.0, 1));
  builder.setPlaces(std::make_shared<const PlaceGraph>(world.makePlaces(60)));
  builder.snapshot();
  builder.erasePrimitives({{1}, {2}, {3}, {7}, {20}});  // so that ids have gaps
  builder.addPrimitives(world.makePrimitives(30, 6.0, 100));
  const Map map = makeMap(builder);
  const test::TemporaryFolder folder;
  writeMap(folder.path() / "map", map);

  scene_graph::SceneGraphBuilder other(config, "odom");
  other.setObjectTasks(world.tasks());
  other.setPlaceTasks(world.tasks());
  restoreBuilder(loadMap(folder.path() / "map").map, other);
  const Map restored = makeMap(other);
  ASSERT_EQ(restored.objectClusters().size(), map.objectClusters().size());
  std::uint64_t gaps = 0;
  for (std::size_t i = 0; i < map.objectClusters().size(); ++i) {
    EXPECT_EQ(restored.objectClusters()[i].id, map.objectClusters()[i].id);
    EXPECT_EQ(restored.objectClusters()[i].primitives, map.objectClusters()[i].primitives);
    gaps += map.objectClusters()[i].id.value - i - 1;
  }
  EXPECT_GT(gaps, 0U);
  ASSERT_EQ(restored.regionClusters().size(), map.regionClusters().size());
  for (std::size_t i = 0; i < map.regionClusters().size(); ++i) {
    EXPECT_EQ(restored.regionClusters()[i].id, map.regionClusters()[i].id);
    EXPECT_EQ(restored.regionClusters()[i].places, map.regionClusters()[i].places);
  }
  writeMap(folder.path() / "again", restored);
  EXPECT_EQ(compareFolders(folder.path() / "map", folder.path() / "again"),
            std::set<std::string>{});
}

TEST(SavedMap, NoIdIsGivenAgainAfterLoading) {
  scene_graph::RandomWorld world(12);
  scene_graph::SceneGraphBuilder builder({}, "odom");
  builder.setObjectTasks(world.tasks());
  builder.addPrimitives(world.makePrimitives(20, 6.0, 1));
  const Map map = makeMap(builder);
  scene_graph::SceneGraphBuilder other({}, "odom");
  other.setObjectTasks(world.tasks());
  restoreBuilder(map, other);
  other.snapshot();
  other.addPrimitives(world.makePrimitives(20, 6.0, 100));
  std::set<std::uint64_t> before;
  for (const auto& cluster : map.objectClusters()) before.insert(cluster.id.value);
  const Map grown = makeMap(other);
  std::size_t num_new = 0;
  for (const auto& cluster : grown.objectClusters()) {
    if (cluster.primitives.front().value < 100) continue;
    ++num_new;
    EXPECT_EQ(before.count(cluster.id.value), 0U);
  }
  EXPECT_GT(num_new, 0U);
}

TEST(SavedMap, AnEmptyMapIsReadBack) {
  const test::TemporaryFolder folder;
  writeMap(folder.path(), Map("odom"));
  const LoadedMap loaded = loadMap(folder.path());
  EXPECT_TRUE(loaded.map.isEmpty());
  EXPECT_EQ(loaded.map.worldFrame(), "odom");
}

}  // namespace
}  // namespace tsg::map
