// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/scene_graph_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <limits>
#include <sstream>

#include "scene_graph_samples.h"
#include "support.h"

namespace tsg::scene_graph {
namespace {

using nlohmann::json;

class SceneGraphFileTest : public ::testing::Test {
 protected:
  std::string write(const std::string& text, const char* name = "in.json") const {
    const auto path = folder_.path() / name;
    std::ofstream(path, std::ios::binary) << text;
    return path.string();
  }
  SceneGraphFile load(const json& graph, Eigen::Index size = 0) const {
    return SceneGraphFile(write(graph.dump()), size);
  }
  std::string errorOf(const std::string& text, Eigen::Index size = 0) const {
    const std::string path = write(text);
    try {
      SceneGraphFile(path, size);
    } catch (const std::runtime_error& e) {
      const std::string what = e.what();
      EXPECT_EQ(what.rfind("scene graph '" + path + "' ", 0), 0U) << what;
      return what;
    }
    return "no exception";
  }

  test::TemporaryFolder folder_;
};

void expectWords(const std::string& text, const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    EXPECT_NE(text.find(word), std::string::npos) << word << " is not in: " << text;
  }
}

json& attributesOf(json& graph, std::size_t i) { return graph["nodes"][i]["attributes"]; }

/// All primitives in one cluster that serves the first task.
std::vector<Cluster> clusterAll(const SceneGraphFile& file) {
  Cluster cluster;
  for (const FilePrimitive& primitive : file.primitives()) cluster.members.push_back(primitive.id);
  std::sort(cluster.members.begin(), cluster.members.end());
  cluster.task = 1;
  return {cluster};
}

json replaceAll(SceneGraphFile& file) {
  file.replaceObjects(clusterAll(file), {"wash"});
  std::ostringstream out;
  file.write(out);
  return json::parse(out.str());
}

const json* findNode(const json& graph, std::uint64_t id) {
  for (const json& node : graph.at("nodes")) {
    if (node.at("id") == id) return &node;
  }
  return nullptr;
}

std::vector<double> toNumbers(const json& values) { return values.get<std::vector<double>>(); }

/// Where the triangle of segment i lies: see makeSegmentAttributes and makeSampleGraph.
std::vector<std::vector<double>> triangleOf(std::size_t i) {
  const double x = 0.5 * static_cast<double>(i) + 10.0;
  return {{x, 2.0, 3.0}, {x + 0.5, 2.0, 3.0}, {x, 2.25, 3.0}};
}

TEST_F(SceneGraphFileTest, ClusteredFilesOfClioHoldAllVerticesRelativeToTheLowerCorner) {
  SceneGraphFile file = load(makeSampleGraph(FileForm::kClio, 3));
  ASSERT_EQ(file.primitives().size(), 3U);
  EXPECT_TRUE(file.primitives()[2].box.isApprox(makeAabb({11.0, 2.0, 3.0}, {12.0, 3.0, 4.0})));
  const json out = replaceAll(file);
  EXPECT_EQ(file.notes(), std::vector<std::string>{});
  const json& merged = findNode(out, makeId('O', 0))->at("attributes");
  const json& box = merged.at("bounding_box");
  EXPECT_EQ(toNumbers(box.at("min")), (std::vector<double>{10.0, 2.0, 3.0}));
  EXPECT_EQ(toNumbers(box.at("max")), (std::vector<double>{12.0, 3.0, 4.0}));
  EXPECT_EQ(toNumbers(box.at("world_P_center")), (std::vector<double>{11.0, 2.5, 3.5}));
  EXPECT_FALSE(merged.contains("mesh"));
  const std::vector<double> vertices = toNumbers(merged.at("vertices"));
  ASSERT_EQ(vertices.size(), 27U);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto triangle = triangleOf(i);
    for (std::size_t v = 0; v < 3; ++v) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double corner = box.at("min")[k].get<double>();
        EXPECT_NEAR(vertices[9 * i + 3 * v + k] + corner, triangle[v][k], 1e-9);
      }
    }
  }
  EXPECT_EQ(merged.at("faces"), json({0, 1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(merged.at("colors").size(), 36U);
  EXPECT_EQ(merged.at("colors")[17], 5);
  EXPECT_EQ(merged.at("name"), "wash");
}

TEST_F(SceneGraphFileTest, ClusteredCurrentFilesHoldAllVerticesRelativeToTheCenter) {
  SceneGraphFile file = load(makeSampleGraph(FileForm::kCurrent, 3));
  const json out = replaceAll(file);
  const json& merged = findNode(out, makeId('O', 0))->at("attributes");
  const json& box = merged.at("bounding_box");
  EXPECT_EQ(toNumbers(box.at("world_P_center")), (std::vector<double>{11.0, 2.5, 3.5}));
  EXPECT_EQ(toNumbers(box.at("dimensions")), (std::vector<double>{2.0, 1.0, 1.0}));
  const json& mesh = merged.at("mesh");
  ASSERT_EQ(mesh.at("points").size(), 9U);
  for (std::size_t i = 0; i < 9; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(mesh.at("points")[i][k].get<double>() + box.at("world_P_center")[k].get<double>(),
                  triangleOf(i / 3)[i % 3][k], 1e-9);
    }
  }
  EXPECT_EQ(mesh.at("faces"), json({{0, 1, 2}, {3, 4, 5}, {6, 7, 8}}));
  EXPECT_EQ(mesh.at("colors").size(), 9U);
  EXPECT_EQ(mesh.at("has_colors"), true);
}

TEST_F(SceneGraphFileTest, OldBoxesByTheirTypesNumberAndCenterAreTheSame) {
  json graph = makeSampleGraph(FileForm::kClio, 1);
  json& box = attributesOf(graph, 0)["bounding_box"];
  const Aabb expected = makeAabb({10.0, 2.0, 3.0}, {11.0, 3.0, 4.0});
  box["type"] = 1;
  EXPECT_TRUE(load(graph).primitives()[0].box.isApprox(expected));
  box["world_P_center"] = {10.5, 2.5, 3.5};
  EXPECT_TRUE(load(graph).primitives()[0].box.isApprox(expected));
  box["min"] = {-0.5, -0.5, -0.5};  // around the centre
  box["max"] = {0.5, 0.5, 0.5};
  EXPECT_TRUE(load(graph).primitives()[0].box.isApprox(expected));
  for (const json& type : {json("OBB"), json(2), json("RAABB"), json(3), json()}) {
    box["type"] = type;
    EXPECT_TRUE(load(graph).primitives()[0].box.isApprox(expected)) << type;
  }
  box["world_R_center"] = {{"w", 1.0}, {"x", 0.0}, {"y", 0.0}, {"z", 1.0}};  // 90 degrees
  box["max"] = {1.5, 0.5, 0.5};
  EXPECT_TRUE(
      load(graph).primitives()[0].box.isApprox(makeAabb({10.0, 2.0, 3.0}, {11.0, 4.0, 4.0})));
}

TEST_F(SceneGraphFileTest, MeshesOfRotatedBoxesAreTurnedIntoTheMergedBox) {
  json graph = makeSampleGraph(FileForm::kCurrent, 2);
  json& box = attributesOf(graph, 1)["bounding_box"];
  box["type"] = "OBB";
  box["world_R_center"] = {{"w", 1.0}, {"x", 0.0}, {"y", 0.0}, {"z", 1.0}};  // x to y
  SceneGraphFile file = load(graph);
  const json out = replaceAll(file);
  const json& merged = findNode(out, makeId('O', 0))->at("attributes");
  const double center_x = merged.at("bounding_box").at("world_P_center")[0].get<double>();
  // (-0.5, -0.5, -0.5) of the box around (11, 2.5, 3.5).
  EXPECT_NEAR(merged.at("mesh").at("points")[3][0].get<double>() + center_x, 11.5, 1e-9);
}

struct BadNode {
  const char* what;
  std::function<void(json& attributes)> spoil;
  const char* words;
};

const std::vector<BadNode>& listBadNodes() {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  static const std::vector<BadNode> bad = {
      {"no embedding", [](json& a) { a.erase("semantic_feature"); }, "no 'semantic_feature'"},
      {"null", [](json& a) { a["semantic_feature"] = nullptr; }, "'semantic_feature' = null"},
      {"text", [](json& a) { a["semantic_feature"] = "x"; }, "'semantic_feature' = \"x\""},
      {"empty matrix",
       [](json& a) {
         a["semantic_feature"] = {{"rows", 0}, {"cols", 0}};
       },
       "no 'data'"},
      {"no numbers", [](json& a) { a["semantic_feature"] = json::array(); }, "empty"},
      {"null in it", [](json& a) { a["semantic_feature"]["data"][1] = nullptr; }, "entry 1 = null"},
      {"NaN in it", [nan](json& a) { a["semantic_feature"]["data"][1] = nan; }, "entry 1 = null"},
      {"too large", [](json& a) { a["semantic_feature"]["data"][1] = 1e300; }, "not finite"},
      {"zeros",
       [](json& a) {
         a["semantic_feature"]["data"] = {0.0, 0.0, 0.0};
       },
       "zeros"},
      {"another size",
       [](json& a) {
         a["semantic_feature"] = {1.0, 2.0};
       },
       "of 2 numbers"},
      {"rows below 0",
       [](json& a) {
         a["semantic_feature"] = {{"rows", -2}, {"cols", -2}, {"data", {1, 2, 3, 4}}};
       },
       "rows = -2"},
      {"huge rows",
       [](json& a) {
         a["semantic_feature"] = {{"rows", 4294967296}, {"cols", 4294967296}, {"data", {1.0}}};
       },
       "rows = 4294967296"},
      {"half a row", [](json& a) { a["semantic_feature"]["rows"] = 1.5; }, "rows = 1.5"},
      {"rows of another size", [](json& a) { a["semantic_feature"]["rows"] = 7; }, "7 x 1"},
      {"no box", [](json& a) { a.erase("bounding_box"); }, "no 'bounding_box'"},
      {"box null", [](json& a) { a["bounding_box"] = nullptr; }, "'bounding_box' = null"},
      {"box without type", [](json& a) { a["bounding_box"].erase("type"); }, "no 'type'"},
      {"unknown type", [](json& a) { a["bounding_box"]["type"] = "CUBE"; }, "'type' = \"CUBE\""},
      {"null in the box", [](json& a) { a["bounding_box"]["world_P_center"][0] = nullptr; },
       "'world_P_center' = [null"},
      {"flat vector",
       [](json& a) {
         a["bounding_box"]["dimensions"] = {1, 2};
       },
       "[1,2]"},
      {"below 0",
       [](json& a) {
         a["bounding_box"]["dimensions"] = {1, -2, 1};
       },
       "none below 0"},
      {"no rotation",
       [](json& a) {
         a["bounding_box"]["type"] = "OBB";
         a["bounding_box"]["world_R_center"] = {{"w", 0}, {"x", 0}, {"y", 0}, {"z", 0}};
       },
       "a quaternion"},
      {"too large a box",
       [](json& a) {
         a["bounding_box"]["dimensions"] = {1e308, 1e308, 1e308};
         a["bounding_box"]["world_P_center"] = {1.7e308, 0, 0};
       },
       "finite numbers"},
      {"no position", [](json& a) { a.erase("position"); }, "no 'position'"},
      {"null in the position", [](json& a) { a["position"][2] = nullptr; }, "'position'"},
      {"no map", [](json& a) { a = 3; }, "no 'attributes'"}};
  return bad;
}

TEST_F(SceneGraphFileTest, ABadNodeStaysAsItIsAndIsNamedWhereverItIs) {
  for (const BadNode& bad : listBadNodes()) {
    for (const std::size_t where : {0U, 2U, 3U}) {
      json graph = makeSampleGraph(FileForm::kCurrent, 4);
      bad.spoil(attributesOf(graph, where));
      const std::string before = graph["nodes"][where].dump();
      SceneGraphFile file = load(graph);
      EXPECT_EQ(file.primitives().size(), 3U) << bad.what;
      EXPECT_EQ(file.numLeftNodes(), 1U) << bad.what;
      const json out = replaceAll(file);
      ASSERT_EQ(file.notes().size(), 1U) << bad.what;
      expectWords(file.notes()[0], {"1 of the nodes to be clustered (layer SEGMENTS)",
                                    describeNode(makeId('s', where)), bad.words});
      EXPECT_EQ(findNode(out, makeId('s', where))->dump(), before) << bad.what;
      for (const json& edge : out.at("edges")) EXPECT_NE(edge.at("target"), makeId('s', where));
      EXPECT_NE(findNode(out, makeId('O', 0)), nullptr);
    }
  }
}

TEST_F(SceneGraphFileTest, ABadObjectStaysAsItIsWhereObjectsAreClustered) {
  for (const BadNode& bad : listBadNodes()) {
    json graph = makeSampleGraph(FileForm::kCurrent, 4);
    for (std::size_t i = 0; i < 4; ++i) graph["nodes"][i]["layer"] = 2;
    bad.spoil(attributesOf(graph, 1));
    const std::string before = graph["nodes"][1].dump();
    SceneGraphFile file = load(graph);
    const json out = replaceAll(file);
    EXPECT_EQ(out.at("nodes").size(), 4U) << bad.what;  // it, the merged one, two places
    EXPECT_EQ(findNode(out, makeId('s', 1))->dump(), before) << bad.what;
    expectWords(file.notes().at(0), {"layer OBJECTS", bad.words});
  }
}

TEST_F(SceneGraphFileTest, AFileWithoutAnyGoodNodeIsRefused) {
  json graph = makeSampleGraph(FileForm::kCurrent, 7);
  for (std::size_t i = 0; i < 7; ++i) attributesOf(graph, i).erase("semantic_feature");
  expectWords(errorOf(graph.dump()), {"no node that can be clustered among the 7", "SEGMENTS",
                                      "s0 (", "s4 (", "and 2 more"});
  const json good = makeSampleGraph(FileForm::kCurrent, 3);
  expectWords(errorOf(good.dump(), 12), {"embedding of 3 numbers, expected the tasks' 12"});
}

TEST_F(SceneGraphFileTest, EmbeddingsOfTheCommonestSizeAreTakenUnlessTheTasksHaveAnother) {
  json graph = makeSampleGraph(FileForm::kCurrent, 5);
  for (const std::size_t i : {0U, 3U}) attributesOf(graph, i)["semantic_feature"] = {1.0, 2.0};
  EXPECT_EQ(load(graph).primitives().size(), 3U);
  EXPECT_EQ(load(graph, 3).primitives().size(), 3U);
  EXPECT_EQ(load(graph, 2).primitives().size(), 2U);
}

TEST_F(SceneGraphFileTest, OfNodesWithOneIdTheFirstIsTaken) {
  json graph = makeSampleGraph(FileForm::kCurrent, 3);
  graph["nodes"].push_back(graph["nodes"][1]);
  const SceneGraphFile file = load(graph);
  EXPECT_EQ(file.primitives().size(), 3U);
  expectWords(file.notes().at(0), {"s1 (", "is there already"});
}

TEST_F(SceneGraphFileTest, EntriesThatAreNoNodesStayAndAreCounted) {
  json graph = makeSampleGraph(FileForm::kCurrent, 2);
  for (const json& entry :
       {json(), json(3), json("s"), json::array(), json::object(), json{{"id", "s7"}, {"layer", 3}},
        json{{"id", -3}, {"layer", 3}}, json{{"id", 1e30}, {"layer", 3}}}) {
    graph["nodes"].push_back(entry);
  }
  graph["nodes"].push_back({{"id", "s8"}, {"layer", 1}});
  SceneGraphFile file = load(graph);
  const json out = replaceAll(file);
  EXPECT_EQ(out.at("nodes").size(), 2U + 2U + 9U + 1U);
  ASSERT_EQ(file.notes().size(), 2U);
  expectWords(file.notes()[0], {"1 of the nodes", "entry 12 of 'nodes' has no 'id'"});
  expectWords(file.notes()[1], {"8 entries of 'nodes' whose 'id', 'layer'", "entry 4; entry 5"});
}

TEST_F(SceneGraphFileTest, NodesOfUnknownTypesAndLayersStayAsTheyAre) {
  json graph = makeSampleGraph(FileForm::kCurrent, 2);
  attributesOf(graph, 0)["type"] = "FutureAttributes";
  const json others[] = {{{"id", 77}, {"layer", 99}, {"attributes", {{"type", "New"}}}},
                         {{"id", 79}, {"layer", 2}, {"partition", 97}, {"attributes", nullptr}},
                         {{"id", 80}, {"layer", 2}, {"timestamp", 5}, {"attributes", nullptr}}};
  for (const json& other : others) graph["nodes"].push_back(other);
  SceneGraphFile file = load(graph);
  EXPECT_EQ(file.primitives().size(), 2U);
  const json out = replaceAll(file);
  for (const json& other : others) {
    const json* found = findNode(out, other.at("id").get<std::uint64_t>());
    ASSERT_NE(found, nullptr) << other;
    EXPECT_EQ(*found, other);
  }
  EXPECT_EQ(file.notes(), std::vector<std::string>{});
}

TEST_F(SceneGraphFileTest, LayersAndPartitionsThatAreNoNumbersAreCounted) {
  for (const auto& [name, value] : {std::pair<const char*, json>{"layer", "1"},
                                    {"layer", 1.5},
                                    {"partition", "a"},
                                    {"partition", nullptr}}) {
    json graph = makeSampleGraph(FileForm::kCurrent, 3);
    graph["nodes"][1][name] = value;
    SceneGraphFile file = load(graph);
    EXPECT_EQ(file.primitives().size(), 2U);
    expectWords(file.notes().at(0), {"1 entry of 'nodes'", "entry 1"});
    EXPECT_EQ(*findNode(replaceAll(file), makeId('s', 1)), graph["nodes"][1]);
  }
}

TEST_F(SceneGraphFileTest, EdgesOfAbsentNodesGoAndAreCounted) {
  json graph = makeSampleGraph(FileForm::kCurrent, 2);
  const auto addEdge = [&](const json& source, const json& target) {
    graph["edges"].push_back(
        {{"source", source}, {"target", target}, {"info", {{"type", "EdgeAttributes"}}}});
  };
  addEdge(makeId('p', 0), makeId('s', 0));
  addEdge(makeId('p', 0), makeId('s', 17));
  addEdge(makeId('q', 0), makeId('s', 0));
  addEdge("p0", makeId('s', 0));
  graph["edges"].push_back(nullptr);
  graph["edges"].push_back(json::object());
  SceneGraphFile file = load(graph);
  const json out = replaceAll(file);
  ASSERT_EQ(file.notes().size(), 1U);
  expectWords(file.notes()[0],
              {"5 edges", "s17 (", "q0 (", "entry 4 of 'edges' has no 'source' and 'target'"});
  // p0-p1, p0-O0, O0-s0, O0-s1
  EXPECT_EQ(out.at("edges").size(), 4U);
}

TEST_F(SceneGraphFileTest, MissingLayersAndHeadersAreNoFault) {
  for (const char* name : {"layer_keys", "layer_names", "SPARK_DSG_header", "directed"}) {
    json graph = makeSampleGraph(FileForm::kCurrent, 2);
    graph.erase(name);
    SceneGraphFile file = load(graph);
    EXPECT_NE(findNode(replaceAll(file), makeId('O', 0)), nullptr) << name;
  }
  json graph = makeSampleGraph(FileForm::kClio, 2);
  graph.erase("layer_ids");
  SceneGraphFile file = load(graph);
  EXPECT_EQ(replaceAll(file).at("layer_ids"), json({2}));
}

TEST_F(SceneGraphFileTest, PartsOfAnotherKindAreRefusedByName) {
  const json good = makeSampleGraph(FileForm::kCurrent, 2);
  for (const char* name : {"nodes", "edges"}) {
    for (const json& value : {json(), json::object(), json("x"), json(3)}) {
      json graph = good;
      graph[name] = value;
      expectWords(errorOf(graph.dump()), {"no list of '" + std::string(name) + "'"});
    }
  }
  json graph = good;
  graph["layer_names"] = {"SEGMENTS"};
  expectWords(errorOf(graph.dump()), {"'layer_names' that are no map"});
  graph = good;
  graph["layer_names"]["OBJECTS"] = "two";
  expectWords(errorOf(graph.dump()), {"layer OBJECTS = \"two\""});
  graph = good;
  graph["layer_keys"] = "all";
  SceneGraphFile file = load(graph);
  try {
    replaceAll(file);
    FAIL();
  } catch (const std::runtime_error& e) {
    expectWords(e.what(), {"in.json", "'layer_keys' that are no list"});
  }
}

TEST_F(SceneGraphFileTest, MeshesThatCannotBeReadAreLeftOutAndNamed) {
  const std::pair<std::function<void(json & mesh)>, const char*> cases[] = {
      {[](json& m) {
         m["points"][1] = {1.0, 2.0};
       },
       "[1.0,2.0], expected three numbers"},
      {[](json& m) { m["points"][1] = 5; }, "has 5, expected three numbers"},
      {[](json& m) { m["points"][1] = nullptr; }, "null, expected three"},
      {[](json& m) { m["points"][1][0] = "x"; }, "a coordinate of a vertex is \"x\""},
      {[](json& m) { m["points"] = "x"; }, "'points' is no list"},
      {[](json& m) { m["faces"][0][2] = 3; }, "a face has the vertex 3"},
      {[](json& m) { m["faces"][0][2] = -1; }, "a face has the vertex -1"},
      {[](json& m) { m["faces"][0][2] = 0.5; }, "a face has the vertex 0.5"},
      {[](json& m) {
         m["faces"] = {0, 1, 2};
       },
       "has 0, expected three numbers"},
      {[](json& m) { m["colors"] = 3; }, "'colors' is no list"},
      {[](json& m) { m = "x"; }, "'mesh' is no mesh"},
      {[](json& m) {
         m = {{"vertices", json::array({1})}};
       },
       "'mesh' has 'vertices'"}};
  for (const auto& [spoil, words] : cases) {
    for (const std::size_t where : {0U, 1U}) {
      json graph = makeSampleGraph(FileForm::kCurrent, 3);
      spoil(attributesOf(graph, where)["mesh"]);
      SceneGraphFile file = load(graph);
      const json out = replaceAll(file);
      ASSERT_EQ(file.notes().size(), 1U) << words;
      expectWords(file.notes()[0], {"1 mesh ", describeNode(makeId('s', where)), words});
      const json& mesh = findNode(out, makeId('O', 0))->at("attributes").at("mesh");
      EXPECT_EQ(mesh.at("points").size(), 6U) << words;
      EXPECT_EQ(mesh.at("faces"), json({{0, 1, 2}, {3, 4, 5}})) << words;
      EXPECT_EQ(mesh.at("has_colors"), true);
    }
  }
}

TEST_F(SceneGraphFileTest, FlatMeshesThatCannotBeReadAreLeftOutAndNamed) {
  const std::pair<std::function<void(json & attributes)>, const char*> cases[] = {
      {[](json& a) { a["vertices"].push_back(1.0); }, "'vertices' has 10 numbers"},
      {[](json& a) { a["vertices"][4] = "x"; }, "a coordinate of a vertex is \"x\""},
      {[](json& a) { a["faces"].push_back(1); }, "'faces' has 4 numbers"},
      {[](json& a) { a["faces"][0] = 3; }, "a face has the vertex 3"},
      {[](json& a) { a["vertices"] = 3; }, "'vertices' is no list"}};
  for (const auto& [spoil, words] : cases) {
    for (const std::size_t where : {0U, 2U}) {
      json graph = makeSampleGraph(FileForm::kClio, 3);
      spoil(attributesOf(graph, where));
      SceneGraphFile file = load(graph);
      const json out = replaceAll(file);
      expectWords(file.notes().at(0), {"1 mesh ", describeNode(makeId('s', where)), words});
      const json& merged = findNode(out, makeId('O', 0))->at("attributes");
      EXPECT_EQ(merged.at("vertices").size(), 18U) << words;
      EXPECT_EQ(merged.at("faces"), json({0, 1, 2, 3, 4, 5})) << words;
    }
  }
}

TEST_F(SceneGraphFileTest, MembersWithoutAMeshAreNoFault) {
  const std::function<void(json&)> takings[] = {[](json& a) { a.erase("mesh"); },
                                                [](json& a) { a["mesh"] = nullptr; },
                                                [](json& a) { a["mesh"] = json::object(); },
                                                [](json& a) {
                                                  a["mesh"]["points"] = json::array();
                                                  a["mesh"]["faces"] = nullptr;
                                                  a["mesh"].erase("colors");
                                                }};
  for (const auto& take : takings) {
    for (const std::size_t where : {0U, 1U}) {
      json graph = makeSampleGraph(FileForm::kCurrent, 3);
      take(attributesOf(graph, where));
      SceneGraphFile file = load(graph);
      const json out = replaceAll(file);
      EXPECT_EQ(file.notes(), std::vector<std::string>{});
      const json& mesh = findNode(out, makeId('O', 0))->at("attributes").at("mesh");
      EXPECT_EQ(mesh.at("points").size(), 6U);
      EXPECT_EQ(mesh.at("colors").size(), 6U);
    }
  }
}

TEST_F(SceneGraphFileTest, ColorsThatOneMemberHasNotGo) {
  json graph = makeSampleGraph(FileForm::kCurrent, 3);
  attributesOf(graph, 1)["mesh"].erase("colors");
  SceneGraphFile file = load(graph);
  const json out = replaceAll(file);
  const json& mesh = findNode(out, makeId('O', 0))->at("attributes").at("mesh");
  EXPECT_EQ(mesh.at("points").size(), 9U);
  EXPECT_FALSE(mesh.contains("colors"));
  EXPECT_EQ(mesh.at("has_colors"), false);
}

TEST_F(SceneGraphFileTest, ObjectsGoToTheNearestPlaceThatHasAPosition) {
  json graph = makeSampleGraph(FileForm::kCurrent, 2);
  graph["nodes"][3]["attributes"]["position"] = {10.0, 2.0, 3.0};
  SceneGraphFile file = load(graph);
  const json out = replaceAll(file);
  const auto has_parent = [](const json& g, std::uint64_t parent) {
    for (const json& edge : g.at("edges")) {
      if (edge.at("source") == parent && edge.at("target") == makeId('O', 0)) return true;
    }
    return false;
  };
  EXPECT_TRUE(has_parent(out, makeId('p', 1)));
  graph["nodes"][3]["attributes"]["position"][0] = nullptr;
  SceneGraphFile other = load(graph);
  EXPECT_TRUE(has_parent(replaceAll(other), makeId('p', 0)));
  expectWords(other.notes().at(0), {"1 place ", "p1 ("});
}

TEST_F(SceneGraphFileTest, NumbersThatJsonDoesNotKnowAreNull) {
  const json graph = makeSampleGraph(FileForm::kCurrent, 3);
  for (const char* odd : {"NaN", "Infinity", "-Infinity", "1e999", "-1E+999", "nan", "-inf"}) {
    std::string text = graph.dump();
    const std::string feature = "\"data\":[1.0,0.25,0.0]";
    text.replace(text.find(feature), feature.size(), "\"data\":[1.0," + std::string(odd) + ",0.0]");
    SceneGraphFile file(write(text));
    EXPECT_EQ(file.primitives().size(), 2U) << odd;
    expectWords(file.notes().at(0), {"s0 (", "entry 1 = null"});
    expectWords(file.notes().at(1), {"1 number that JSON does not know"});
    json expected = graph;
    attributesOf(expected, 0)["semantic_feature"]["data"][1] = nullptr;
    EXPECT_EQ(*findNode(replaceAll(file), makeId('s', 0)), expected["nodes"][0]) << odd;
  }
}

TEST_F(SceneGraphFileTest, WordsLikeNumbersInStringsStay) {
  json graph = makeSampleGraph(FileForm::kCurrent, 2);
  const std::string name = "NaN \"1e999\" \\ [[[ Infinity";
  attributesOf(graph, 0)["name"] = name;
  graph["metadata"] = {{"NaN", "1e999"}};
  SceneGraphFile file = load(graph);
  const json out = replaceAll(file);
  EXPECT_EQ(findNode(out, makeId('s', 0))->at("attributes").at("name"), name);
  EXPECT_EQ(out.at("metadata"), graph.at("metadata"));
  EXPECT_EQ(file.notes(), std::vector<std::string>{});
}

TEST_F(SceneGraphFileTest, FilesThatAreNoGraphsAreRefusedWithWhatTheyAre) {
  const std::string good = makeSampleGraph(FileForm::kCurrent, 2).dump();
  std::string deep = "{\"nodes\": [], \"edges\": [], \"x\": ";
  for (int i = 0; i < 100'000; ++i) deep += i % 2 == 0 ? "[" : "{\"a\":";
  const std::pair<std::string, std::vector<std::string>> cases[] = {
      {"", {"is empty"}},
      {"  \n", {"nothing but spaces"}},
      {"{ not json", {"is not JSON", "line 1, column "}},
      {good.substr(0, good.size() / 2), {"is not JSON or cut off"}},
      {good + good, {"is not JSON"}},
      {"[]", {"no list of 'nodes'"}},
      {"null", {"no list of 'nodes'"}},
      {"3", {"no list of 'nodes'"}},
      {"{}", {"no list of 'nodes'"}},
      {"\"nodes edges\"", {"no list of 'nodes'"}},
      {std::string("\x1f\x8b\x08\0\0", 5), {"gzip", "gunzip"}},
      {"<!DOCTYPE html><html>", {"web page"}},
      {"version https://git-lfs.github.com/spec/v1\n", {"Git LFS"}},
      {"\xff\xfe{\0}", {"UTF-16"}},
      {"{\"nodes\": [\"\xc3\x28\"], \"edges\": []}", {"is not JSON", "UTF-8"}},
      {deep, {"deeper than 256 levels"}},
      {std::string(100'000, '['), {"deeper than 256 levels"}},
      {std::string(100'000, ']'), {"is not JSON"}},
      {"tasks:\n- a mug\n", {"is not JSON"}}};
  for (const auto& [text, words] : cases) expectWords(errorOf(text), words);
}

TEST_F(SceneGraphFileTest, TasksWhoseNamesAreNoUtf8AreRefused) {
  SceneGraphFile file = load(makeSampleGraph(FileForm::kCurrent, 2));
  try {
    file.replaceObjects(clusterAll(file), {"caf\xe9"});
    FAIL();
  } catch (const std::invalid_argument& e) {
    expectWords(e.what(), {"task 1", "UTF-8"});
  }
  file.replaceObjects(clusterAll(file), {"caf\xc3\xa9"});
}

TEST_F(SceneGraphFileTest, AByteOrderMarkIsNoFault) {
  SceneGraphFile file(write("\xef\xbb\xbf" + makeSampleGraph(FileForm::kCurrent, 2).dump()));
  EXPECT_EQ(file.primitives().size(), 2U);
}

TEST_F(SceneGraphFileTest, FoldersAndAbsentFilesAreNamed) {
  for (const std::string& path : {folder_.path().string(), std::string("/no/such/graph.json")}) {
    try {
      SceneGraphFile{path};
      FAIL();
    } catch (const std::runtime_error& e) {
      expectWords(e.what(), {"scene graph '" + path + "' "});
    }
  }
}

}  // namespace
}  // namespace tsg::scene_graph
