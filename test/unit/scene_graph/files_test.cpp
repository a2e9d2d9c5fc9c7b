// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/files.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "sample_graph.h"
#include "support.h"

namespace tsg::scene_graph {
namespace {

using Json = nlohmann::json;

Json parseFile(const std::string& path) { return Json::parse(std::ifstream(path)); }

class Files : public ::testing::Test {
 protected:
  std::string path() const { return (folder_.path() / "graph.json").string(); }
  Json writeAndReadSummary(const SceneGraph& graph) const {
    writeSummary(path(), graph);
    return parseFile(path());
  }
  Json writeAndReadSparkDsg(const SceneGraph& graph, const SparkDsgOptions& options = {}) const {
    writeSparkDsg(path(), graph, options);
    return parseFile(path());
  }

 private:
  test::TemporaryFolder folder_;
};

std::uint64_t toNodeId(char prefix, std::uint64_t index) {
  return static_cast<std::uint64_t>(prefix) * (std::uint64_t{1} << 56U) + index;
}

const Json& findNode(const Json& file, std::uint64_t id) {
  for (const auto& node : file.at("nodes")) {
    if (node.at("id") == id) return node;
  }
  throw std::out_of_range("no such node");
}

std::set<std::pair<std::uint64_t, std::uint64_t>> readEdges(const Json& file) {
  std::set<std::pair<std::uint64_t, std::uint64_t>> edges;
  for (const auto& edge : file.at("edges")) edges.emplace(edge.at("source"), edge.at("target"));
  return edges;
}

std::size_t countLayer(const Json& file, int layer) {
  std::size_t count = 0;
  for (const auto& node : file.at("nodes")) count += node.at("layer") == layer ? 1 : 0;
  return count;
}

TEST_F(Files, BothNameTheFrameOfTheMap) {
  SceneGraph graph = makeSampleGraph();
  graph.world_frame = "odom";
  EXPECT_EQ(writeAndReadSummary(graph).at("frame"), "odom");
  EXPECT_EQ(writeAndReadSparkDsg(graph).at("metadata").at("frame"), "odom");
}

TEST_F(Files, SummaryListsObjectsUnderTheRoomOfTheirPlace) {
  const Json summary = writeAndReadSummary(makeSampleGraph());
  ASSERT_EQ(summary.at("rooms").size(), 3U);
  const Json& kitchen = summary["rooms"][0];
  EXPECT_EQ(kitchen.at("id"), 2);
  EXPECT_EQ(kitchen.at("task"), "kitchen");
  EXPECT_EQ(kitchen.at("num_places"), 2);
  EXPECT_EQ(kitchen.at("neighbours"), Json({11}));
  ASSERT_EQ(kitchen.at("objects").size(), 1U);
  EXPECT_TRUE(summary["rooms"][1].at("task").is_null());
  EXPECT_TRUE(summary["rooms"][1].at("objects").empty());
}

TEST_F(Files, SummarySaysWhereAnObjectIsAndWhatItServes) {
  const Json object = writeAndReadSummary(makeSampleGraph())["rooms"][0]["objects"][0];
  EXPECT_EQ(object.at("id"), 5);
  EXPECT_EQ(object.at("task"), "wash the \"dishes\"");
  EXPECT_EQ(object.at("score"), 0.875);
  EXPECT_EQ(object.at("position_m"), Json({0.75, 0.5, 0.5}));
  EXPECT_EQ(object.at("orientation_xyzw"), Json({0, 0, 0, 1}));
  EXPECT_EQ(object.at("box_min_m"), Json({0.0, 0.0, 0.0}));
  EXPECT_EQ(object.at("box_max_m"), Json({1.5, 1.0, 1.0}));
  EXPECT_EQ(object.at("place"), 1);
  EXPECT_EQ(object.at("num_primitives"), 2);
  EXPECT_NEAR(object.at("first_seen_s").get<double>(), 1600000000.123456790, 1e-6);
}

TEST_F(Files, ObjectsOfNoRegionStandUnderTheRoomNull) {
  const Json rest = writeAndReadSummary(makeSampleGraph())["rooms"][2];
  EXPECT_TRUE(rest.at("id").is_null());
  ASSERT_EQ(rest.at("objects").size(), 2U);
  EXPECT_EQ(rest["objects"][0].at("place"), 7);
  EXPECT_TRUE(rest["objects"][1].at("place").is_null());
  EXPECT_EQ(rest["objects"][0].at("task"), "Kissen holen: für mich");
}

TEST_F(Files, SummaryCountsEveryTaskAlsoThoseWithoutObjects) {
  const Json summary = writeAndReadSummary(makeSampleGraph());
  EXPECT_EQ(summary.at("objects_per_task"),
            Json::parse(R"([{"task": "wash the \"dishes\"", "objects": 1},
                            {"task": "Kissen holen: für mich", "objects": 2},
                            {"task": "nothing serves this", "objects": 0}])"));
  EXPECT_EQ(summary.at("rooms_per_task"), Json::parse(R"([{"task": "kitchen", "rooms": 1},
                                                          {"task": "office", "rooms": 0}])"));
  EXPECT_EQ(summary.at("counts"),
            Json::parse(R"({"objects": 3, "rooms": 2, "places": 4, "primitives": 4})"));
  EXPECT_EQ(summary.at("config").at("object_delta"), 1e-5);
}

TEST_F(Files, EmptyGraphsAreWritten) {
  SceneGraph graph;
  graph.places = std::make_shared<PlaceGraph>();
  EXPECT_TRUE(writeAndReadSummary(graph).at("rooms").empty());
  const Json file = writeAndReadSparkDsg(graph);
  EXPECT_TRUE(file.at("nodes").empty());
  EXPECT_TRUE(file.at("edges").empty());
}

TEST_F(Files, SparkDsgNodesLieInTheirLayers) {
  const Json file = writeAndReadSparkDsg(makeSampleGraph());
  EXPECT_EQ(countLayer(file, 1), 4U);
  EXPECT_EQ(countLayer(file, 2), 3U);
  EXPECT_EQ(countLayer(file, 3), 4U);
  EXPECT_EQ(countLayer(file, 4), 2U);
  EXPECT_EQ(file.at("layer_names").at("SEGMENTS").at("layer"), 1);
  EXPECT_EQ(findNode(file, toNodeId('O', 5)).at("attributes").at("name"), "wash the \"dishes\"");
  EXPECT_EQ(findNode(file, toNodeId('l', 2)).at("attributes").at("name"), "kitchen");
  EXPECT_EQ(findNode(file, toNodeId('p', 1)).at("attributes").at("distance"), 0.75);
}

TEST_F(Files, SparkDsgEdgesJoinAndNest) {
  using Edge = std::pair<std::uint64_t, std::uint64_t>;
  const auto edges = readEdges(writeAndReadSparkDsg(makeSampleGraph()));
  const auto id = toNodeId;
  EXPECT_EQ(edges, (std::set<Edge>{{id('p', 1), id('p', 2)},
                                   {id('p', 2), id('p', 4)},
                                   {id('p', 4), id('p', 7)},
                                   {id('l', 2), id('l', 11)},
                                   {id('l', 2), id('p', 1)},
                                   {id('l', 2), id('p', 2)},
                                   {id('l', 11), id('p', 4)},
                                   {id('p', 1), id('O', 5)},
                                   {id('p', 7), id('O', 6)},
                                   {id('O', 5), id('s', 1)},
                                   {id('O', 5), id('s', 2)},
                                   {id('O', 6), id('s', 3)},
                                   {id('O', 8), id('s', 9)}}));
}

TEST_F(Files, SparkDsgEmbeddingsKeepEveryBit) {
  const SceneGraph graph = makeSampleGraph();
  const Json file = writeAndReadSparkDsg(graph);
  const Json feature = findNode(file, toNodeId('s', 3)).at("attributes").at("semantic_feature");
  EXPECT_EQ(feature.at("rows"), 3);
  EXPECT_EQ(feature.at("cols"), 1);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(feature.at("data")[static_cast<std::size_t>(i)].get<float>(),
              graph.primitives[2]->embedding[i]);
  }
  EXPECT_FALSE(findNode(file, toNodeId('s', 9)).at("attributes").contains("semantic_feature"));
}

TEST_F(Files, SparkDsgLeavesOutWhatIsNotAskedFor) {
  const Json all = writeAndReadSparkDsg(makeSampleGraph(), {true, true, true});
  EXPECT_EQ(findNode(all, toNodeId('O', 5)).at("attributes").at("mesh").at("points").size(), 8U);
  const Json bare = writeAndReadSparkDsg(makeSampleGraph(), {false, false, false});
  EXPECT_EQ(countLayer(bare, 1), 0U);
  EXPECT_FALSE(bare.at("layer_names").contains("SEGMENTS"));
  EXPECT_EQ(readEdges(bare).size(), 9U);
  const Json attributes = findNode(bare, toNodeId('O', 5)).at("attributes");
  EXPECT_FALSE(attributes.contains("mesh"));
  EXPECT_FALSE(attributes.contains("semantic_feature"));
}

TEST_F(Files, SparkDsgMetadataHoldTasksAndParameters) {
  SceneGraph graph = makeSampleGraph();
  graph.config.object_alpha = 0.5;
  graph.config.place_delta = 0.25;
  const Json metadata = writeAndReadSparkDsg(graph).at("metadata");
  EXPECT_EQ(metadata.at("object_tasks"), Json(graph.object_tasks));
  EXPECT_EQ(metadata.at("place_tasks"), Json(graph.place_tasks));
  EXPECT_EQ(metadata.at("config").at("object_alpha"), 0.5);
  EXPECT_EQ(metadata.at("config").at("place_delta"), 0.25);
  EXPECT_EQ(metadata.at("stamp_ns"), 1600000010000000000);
}

TEST_F(Files, BytesThatAreNotUtf8AreReplacedNotThrownOver) {
  SceneGraph graph = makeSampleGraph();
  graph.objects[0].task = "caf\xe9";
  EXPECT_EQ(writeAndReadSummary(graph)["rooms"][0]["objects"][0].at("task"), "caf\xef\xbf\xbd");
}

TEST(FileErrors, NameThePath) {
  const SceneGraph graph = makeSampleGraph();
  for (const auto& write : {+[](const SceneGraph& g) { writeSummary("/proc/none/s.json", g); },
                            +[](const SceneGraph& g) { writeSparkDsg("/proc/none/s.json", g); }}) {
    try {
      write(graph);
      FAIL() << "wrote into /proc";
    } catch (const std::runtime_error& e) {
      EXPECT_NE(std::string(e.what()).find("/proc/none/s.json"), std::string::npos) << e.what();
    }
  }
}

}  // namespace
}  // namespace tsg::scene_graph
