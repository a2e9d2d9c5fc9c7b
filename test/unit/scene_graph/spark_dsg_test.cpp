// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "sample_graph.h"
#include "support.h"
#include "task_scene_graph/scene_graph/files.h"

// Writes a graph, and what a reader should find in it, and has spark_dsg_load_test.py compare them.
namespace tsg::scene_graph {
namespace {

using Json = nlohmann::json;

constexpr int kCannotImport = 77;

template <typename Tag>
std::string symbol(char prefix, Id<Tag> id) {
  return prefix + std::to_string(id.value);
}
std::string symbol(PrimitiveId id) { return symbol('s', id); }
std::string symbol(ObjectId id) { return symbol('O', id); }
std::string symbol(PlaceId id) { return symbol('p', id); }
std::string symbol(RegionId id) { return symbol('l', id); }

Json toJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json makeNode(const Eigen::Vector3d& position_m, const Embedding& embedding) {
  return {{"position", toJson(position_m)},
          {"feature", std::vector<float>(embedding.data(), embedding.data() + embedding.size())}};
}

/// `box` and times of objects and primitives.
void addSolid(Json& node, const Aabb& box, Stamp first_seen, Stamp last_seen) {
  node["box"] = {toJson(box.min()), toJson(box.max())};
  node["seen"] = {first_seen.ns, last_seen.ns};
}

void expectPrimitives(const SceneGraph& graph, Json& expected) {
  for (const auto& primitive : graph.primitives) {
    Json node = makeNode(primitive->box.center(), primitive->embedding);
    addSolid(node, primitive->box, primitive->first_seen, primitive->last_seen);
    node["num_vertices"] = primitive->mesh.vertices.size();
    node["num_faces"] = primitive->mesh.triangles.size();
    expected["segments"][symbol(primitive->id)] = node;
  }
}

void expectObjects(const SceneGraph& graph, Json& expected) {
  for (const auto& object : graph.objects) {
    Json node = makeNode(object.position_m, object.embedding);
    addSolid(node, object.box, object.first_seen, object.last_seen);
    node["name"] = object.task;
    node["label"] = object.task_index;
    expected["objects"][symbol(object.id)] = node;
    for (const PrimitiveId id : object.primitives) {
      expected["parents"][symbol(id)] = symbol(object.id);
    }
    if (object.place.isValid()) expected["parents"][symbol(object.id)] = symbol(object.place);
  }
}

void expectPlaces(const SceneGraph& graph, Json& expected) {
  for (const auto& place : graph.places->places) {
    Json node = makeNode(place.position_m, place.embedding);
    node["distance"] = place.clearance_m;
    expected["places"][symbol(place.id)] = node;
  }
  for (const auto& edge : graph.places->edges) {
    expected["place_edges"].push_back({symbol(edge.a), symbol(edge.b), edge.clearance_m});
    expected["edges"].push_back({symbol(edge.a), symbol(edge.b)});
  }
}

void expectRegions(const SceneGraph& graph, Json& expected) {
  for (const auto& region : graph.regions) {
    Json node = makeNode(region.position_m, region.embedding);
    node["name"] = region.task;
    if (region.task_index >= 0) node["label"] = region.task_index;
    expected["regions"][symbol(region.id)] = node;
    for (const PlaceId place : region.places) {
      expected["parents"][symbol(place)] = symbol(region.id);
    }
  }
  for (const auto& edge : graph.region_edges) {
    expected["edges"].push_back({symbol(edge.a), symbol(edge.b)});
  }
}

Json makeExpectation(const SceneGraph& graph) {
  Json expected;
  expectPrimitives(graph, expected);
  expectObjects(graph, expected);
  expectPlaces(graph, expected);
  expectRegions(graph, expected);
  for (const auto& [child, parent] : expected["parents"].items()) {
    expected["edges"].push_back({child, parent});
  }
  expected["metadata"] = {{"object_tasks", graph.object_tasks}, {"place_tasks", graph.place_tasks}};
  expected["config"] = {{"object_alpha", graph.config.object_alpha},
                        {"object_delta", graph.config.object_delta},
                        {"place_alpha", graph.config.place_alpha},
                        {"place_delta", graph.config.place_delta}};
  return expected;
}

/// Exit status and output of a shell command.
std::pair<int, std::string> runCommand(const std::string& command) {
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot run " + command);
  std::string output;
  for (int byte = std::fgetc(pipe); byte != EOF; byte = std::fgetc(pipe)) {
    output += static_cast<char>(byte);
  }
  const int status = pclose(pipe);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, output};
}

TEST(SparkDsgPackage, LoadsWhatWasWritten) {
  const test::TemporaryFolder folder;
  const std::string graph_path = (folder.path() / "graph.json").string();
  const std::string expected_path = (folder.path() / "expected.json").string();
  const SceneGraph graph = makeSampleGraph();
  SparkDsgOptions options;
  options.meshes = true;
  writeSparkDsg(graph_path, graph, options);
  std::ofstream(expected_path) << makeExpectation(graph);

  const std::string script =
      std::string(TSG_SOURCE_DIR) + "/test/unit/scene_graph/" + "spark_dsg_load_test.py";
  const auto [status, output] =
      runCommand("'" + script + "' '" + graph_path + "' '" + expected_path + "'");
  if (status == kCannotImport) GTEST_SKIP() << output;
  EXPECT_EQ(status, 0) << output;
}

}  // namespace
}  // namespace tsg::scene_graph
