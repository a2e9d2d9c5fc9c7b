// SPDX-License-Identifier: BSD-3-Clause
// Clusters the primitives of a spark_dsg scene graph for a list of tasks, in batch.

#include <algorithm>
#include <functional>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "task_scene_graph/bottleneck/clustering.h"
#include "task_scene_graph/bottleneck/scene_graph_file.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/core/files.h"
#include "task_scene_graph/language/text_encoder.h"
#include "task_scene_graph/scene_graph/tasks.h"
#include "task_scene_graph/segmentation/model_set.h"

using namespace tsg;

namespace {

constexpr const char* kUsage =
    "usage: cluster_scene_graph --input dsg.json --tasks tasks.yaml --output out.json [options]\n"
    "Clusters the SEGMENTS layer (OBJECTS where that is absent) of a spark_dsg JSON scene graph,\n"
    "version 1.0 or 1.1, and writes the graph with one object per cluster.\n"
    "  --alpha A         score of the null task (default 0.23)\n"
    "  --delta D         threshold of the normaliser (default 1e-5; size_invariant: 0.03)\n"
    "  --top-k K         tasks kept per primitive, the null task included (default 2)\n"
    "  --prior P         uniform or marginal (default uniform)\n"
    "  --normaliser N    paper or size_invariant (default paper)\n"
    "  --tape FILE       write I(X;Y), the accepted merges and the partition as JSON\n"
    "  --models M.yaml   model set whose text encoder encodes tasks that have no embedding\n"
    "  --help            this text\n";

struct Arguments {
  std::map<std::string, std::string> values;  // by option

  bool has(const std::string& name) const { return values.count(name) > 0; }
  std::string get(const std::string& name) const {
    if (has(name)) return values.at(name);
    throw std::invalid_argument(name + " is missing\n" + kUsage);
  }
};

Arguments parse(const std::vector<std::string>& words) {
  static const std::vector<std::string> kOptions = {
      "--input", "--tasks",      "--output", "--alpha",  "--delta", "--top-k",
      "--prior", "--normaliser", "--tape",   "--models", "--help"};
  Arguments arguments;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (std::find(kOptions.begin(), kOptions.end(), word) == kOptions.end()) {
      throw std::invalid_argument("unknown option '" + word + "'\n" + kUsage);
    }
    if (word == "--help") {
      arguments.values[word] = "";
    } else if (i + 1 == words.size()) {
      throw std::invalid_argument(word + " needs a value");
    } else {
      arguments.values[word] = words[++i];
    }
  }
  return arguments;
}

template <typename T>
T toNumber(const std::string& option, const std::string& text,
           T (*convert)(const std::string&, std::size_t*)) {
  std::size_t length = 0;
  try {
    const T value = convert(text, &length);
    if (length == text.size()) return value;
  } catch (const std::logic_error&) {  // not a number, or too large for one: as below
  }
  throw std::invalid_argument(option + " is '" + text + "', expected " +
                              (std::is_integral_v<T> ? "a whole number" : "a number"));
}

template <typename Enum>
Enum toChoice(const std::string& option, const std::string& text,
              const std::map<std::string, Enum>& choices) {
  if (choices.count(text) > 0) return choices.at(text);
  std::string names;
  for (const auto& [name, value] : choices) names += (names.empty() ? "" : " or ") + name;
  throw std::invalid_argument(option + " is '" + text + "', expected " + names);
}

double toDouble(const std::string& text, std::size_t* length) { return std::stod(text, length); }
int toInt(const std::string& text, std::size_t* length) { return std::stoi(text, length); }

bottleneck::ClusteringConfig makeConfig(const Arguments& arguments) {
  using bottleneck::Normaliser;
  using bottleneck::Prior;
  bottleneck::ClusteringConfig config;
  const auto set = [&](const std::string& option, const auto& apply) {
    if (arguments.has(option)) apply(option, arguments.get(option));
  };
  set("--normaliser", [&](const auto& option, const auto& text) {
    config.normaliser = toChoice<Normaliser>(
        option, text,
        {{"paper", Normaliser::kPaper}, {"size_invariant", Normaliser::kSizeInvariant}});
  });
  set("--prior", [&](const auto& option, const auto& text) {
    config.prior = toChoice<Prior>(option, text,
                                   {{"uniform", Prior::kUniform}, {"marginal", Prior::kMarginal}});
  });
  set("--alpha", [&](const auto& option, const auto& text) {
    config.alpha = toNumber<double>(option, text, toDouble);
  });
  set("--delta", [&](const auto& option, const auto& text) {
    const bool is_paper = config.normaliser == Normaliser::kPaper;
    (is_paper ? config.delta : config.delta_bits) = toNumber<double>(option, text, toDouble);
  });
  set("--top-k", [&](const auto& option, const auto& text) {
    config.top_k = toNumber<int>(option, text, toInt);
  });
  config::validate(config, "cluster_scene_graph");
  return config;
}

scene_graph::TaskList readTasks(const Arguments& arguments) {
  const std::string path = arguments.get("--tasks");
  scene_graph::TaskList tasks = scene_graph::loadTasks(path);
  if (tasks.hasEmbeddings() || tasks.size() == 0) return tasks;
  if (!arguments.has("--models")) {
    throw std::invalid_argument("tasks '" + path + "': task '" + tasks.names.front() +
                                "' has no embedding; expected one per task, or --models");
  }
  const language::TextEncoder encoder(segmentation::loadModelSet(arguments.get("--models")), {});
  tasks.embeddings = encoder.encodeTasks(tasks.names);
  return tasks;
}

bottleneck::IncrementalClustering makeClustering(const Arguments& arguments,
                                                 const scene_graph::TaskList& tasks,
                                                 const bottleneck::SceneGraphFile& graph) {
  bottleneck::IncrementalClustering clustering(makeConfig(arguments),
                                               bottleneck::Adjacency::kBoxOverlap);
  clustering.setTasks(tasks.embeddings);
  for (const bottleneck::FilePrimitive& primitive : graph.primitives()) {
    try {
      clustering.insert(primitive.id, primitive.embedding, primitive.box);
    } catch (const std::invalid_argument& e) {
      throw std::invalid_argument("scene graph '" + arguments.get("--input") + "': node " +
                                  bottleneck::describeNode(primitive.id) + ": " + e.what());
    }
  }
  return clustering;
}

nlohmann::json makeTape(bottleneck::IncrementalClustering& clustering) {
  nlohmann::json merges = nlohmann::json::array();
  for (const bottleneck::Merge& merge : clustering.mergeSequence()) {
    merges.push_back({{"a", merge.a}, {"b", merge.b}, {"d", merge.d}, {"delta", merge.delta}});
  }
  std::vector<std::vector<bottleneck::NodeKey>> partition;
  for (const bottleneck::Cluster& cluster : clustering.clusters()) {
    partition.push_back(cluster.members);
  }
  std::sort(partition.begin(), partition.end());
  return {{"information", clustering.information()},
          {"merges", std::move(merges)},
          {"clusters", std::move(partition)}};
}

void run(const Arguments& arguments) {
  const std::string input = arguments.get("--input");
  const std::string output = arguments.get("--output");
  const scene_graph::TaskList tasks = readTasks(arguments);
  bottleneck::SceneGraphFile graph(input);
  auto clustering = makeClustering(arguments, tasks, graph);
  const std::vector<bottleneck::Cluster> clusters = clustering.clusters();
  graph.replaceObjects(clusters, tasks.names);
  writeFileAtomically(output, [&](std::ostream& out) { graph.write(out); });
  if (arguments.has("--tape")) {
    const nlohmann::json tape = makeTape(clustering);
    writeFileAtomically(arguments.get("--tape"), [&](std::ostream& out) { out << tape << '\n'; });
  }
  std::cout << output << ": " << graph.primitives().size() << " primitives in " << clusters.size()
            << " clusters, I(X;Y) = " << clustering.information() << " bits\n";
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Arguments arguments = parse({argv + 1, argv + argc});
    if (arguments.has("--help")) {
      std::cout << kUsage;
    } else {
      run(arguments);
    }
    return 0;
  } catch (const std::exception& e) {
    std::cerr << "cluster_scene_graph: " << e.what() << '\n';
    return 1;
  }
}
