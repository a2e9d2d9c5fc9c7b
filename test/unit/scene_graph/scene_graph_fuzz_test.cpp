// SPDX-License-Identifier: BSD-3-Clause
// Scene graph files with seeded faults: each is clustered or refused by name, and what is written
// can be read again. TSG_FUZZ_RUNS sets how many (10,000).
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>

#include "scene_graph_samples.h"
#include "support.h"
#include "task_scene_graph/bottleneck/clustering.h"
#include "task_scene_graph/scene_graph/scene_graph_file.h"

namespace tsg::scene_graph {
namespace {

using nlohmann::json;

class Mutator {
 public:
  explicit Mutator(unsigned seed) : random_(seed) {}

  std::string spoil(json graph) {
    const int changes = 1 + pick(3);
    for (int i = 0; i < changes; ++i) spoilValue(graph);
    std::string text = graph.dump();
    for (int i = pick(4) == 0 ? 1 + pick(4) : 0; i > 0; --i) spoilBytes(text);
    return text;
  }

 private:
  int pick(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random_); }

  /// Walks down from the root to a value and changes it.
  void spoilValue(json& root) {
    json* value = &root;
    while (value->is_structured() && !value->empty() && pick(6) != 0) {
      auto child = value->begin();
      std::advance(child, pick(static_cast<int>(value->size())));
      value = &*child;
    }
    change(*value);
  }

  void change(json& value) {
    static const json kOdd[] = {json(),
                                json(true),
                                json(0),
                                json(1),
                                json(2),
                                json(-1),
                                json(-2),
                                json(1.5),
                                json(1e308),
                                json(-1e308),
                                json(4294967296),
                                json(std::numeric_limits<std::uint64_t>::max()),
                                json(std::numeric_limits<std::int64_t>::min()),
                                json(""),
                                json("AABB"),
                                json("OBB"),
                                json("\xf0\x9f\xa4\x96"),
                                json::array(),
                                json::object(),
                                json({1, 2, 3}),
                                json({json({1, 2, 3})}),
                                json({{"w", 0}, {"x", 0}, {"y", 0}, {"z", 0}}),
                                json({{"rows", -2}, {"cols", -2}, {"data", {1, 2, 3, 4}}}),
                                json({{"points", {1, 2}}})};
    if (value.is_structured() && !value.empty() && pick(3) == 0) {
      auto child = value.begin();
      std::advance(child, pick(static_cast<int>(value.size())));
      const json copy = *child;
      if (pick(2) == 0) {
        value.erase(child);
      } else if (value.is_array()) {
        value.push_back(copy);
      } else {
        value[pick(2) == 0 ? "points" : "layer_ids"] = copy;
      }
      return;
    }
    value = kOdd[pick(static_cast<int>(std::size(kOdd)))];
  }

  void spoilBytes(std::string& text) {
    static const char* const kPieces[] = {"NaN", "1e999", "[", "]",    "{", "}",  "\"",     ",",
                                          "\\",  "null",  "-", "\xff", "0", "\n", "\\ud800"};
    if (text.empty()) return;
    const auto at = static_cast<std::size_t>(pick(static_cast<int>(text.size())));
    switch (pick(3)) {
      case 0:
        text[at] = static_cast<char>(pick(256));
        break;
      case 1:
        text.insert(at, kPieces[pick(static_cast<int>(std::size(kPieces)))]);
        break;
      default:
        text.erase(at, static_cast<std::size_t>(1 + pick(20)));
    }
  }

  std::mt19937 random_;
};

/// To a new file: filling an old one anew waits for the disk.
void write(const std::string& path, const std::string& text) {
  std::filesystem::remove(path);
  std::ofstream(path, std::ios::binary) << text;
}

/// Clusters as cluster_scene_graph does, merging whatever touches.
std::string clusterFile(SceneGraphFile& file) {
  bottleneck::ClusteringConfig config;
  config.delta = 1.0;
  bottleneck::IncrementalClustering clustering(config, bottleneck::Adjacency::kBoxOverlap);
  clustering.setTasks((EmbeddingMatrix(1, 3) << 1.0F, 0.0F, 0.0F).finished());
  for (const FilePrimitive& primitive : file.primitives()) {
    clustering.insert(primitive.id, primitive.embedding, primitive.box);
  }
  file.replaceObjects(clustering.clusters(), {"wash"});
  std::ostringstream out;
  file.write(out);
  return out.str();
}

/// Number of runs that were clustered.
int fuzz(const json& graph, int runs, unsigned seed) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "in.json").string();
  Mutator mutator(seed);
  int clustered = 0;
  for (int run = 0; run < runs; ++run) {
    const std::string text = mutator.spoil(graph);
    write(path, text);
    std::string result;
    try {
      SceneGraphFile file(path, 3);
      result = clusterFile(file);
    } catch (const std::runtime_error& e) {
      const std::string what = e.what();
      EXPECT_EQ(what.rfind("scene graph '" + path + "' ", 0), 0U) << what << '\n' << text;
      EXPECT_EQ(what.find("json.exception"), std::string::npos) << what;
      continue;
    }
    ++clustered;
    write(path, result);
    EXPECT_NO_THROW(SceneGraphFile(path, 3)) << text;
    if (::testing::Test::HasFailure()) return clustered;
  }
  return clustered;
}

int countRuns() {
  const char* given = std::getenv("TSG_FUZZ_RUNS");
  return given == nullptr ? 10'000 : std::atoi(given);
}

TEST(SceneGraphFuzz, SpoiltFilesAreClusteredOrRefusedByName) {
  const int runs = countRuns() / 4;
  unsigned seed = 1;
  for (const FileForm form : {FileForm::kClio, FileForm::kCurrent}) {
    json graph = makeSampleGraph(form, 3);
    const int segments = fuzz(graph, runs, seed++);
    for (std::size_t i = 0; i < 3; ++i) graph["nodes"][i]["layer"] = 2;
    const int objects = fuzz(graph, runs, seed++);
    // Most faults are in one node, and the others are clustered.
    EXPECT_GT(segments, runs / 2);
    EXPECT_GT(objects, runs / 2);
    EXPECT_LT(segments, runs);
  }
}

}  // namespace
}  // namespace tsg::scene_graph
