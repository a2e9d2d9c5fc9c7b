// SPDX-License-Identifier: BSD-3-Clause
// Clusters the primitives of a spark_dsg scene graph for a list of tasks, in batch.

#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "command_line.h"
#include "task_scene_graph/bottleneck/clustering.h"
#include "task_scene_graph/bottleneck/reach.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/core/files.h"
#include "task_scene_graph/language/text_encoder.h"
#include "task_scene_graph/scene_graph/scene_graph_file.h"
#include "task_scene_graph/scene_graph/tasks.h"
#include "task_scene_graph/segmentation/model_set.h"

namespace options = boost::program_options;
using namespace tsg;

namespace {

struct Arguments {
  std::string input;
  std::string tasks;
  std::string output;
  std::string tape;
  std::string models;
  double reach = 0.0;
  bottleneck::ClusteringConfig config;
};

// `given` as config::load takes it.
bottleneck::ClusteringConfig makeConfig(const YAML::Node& given, const std::string& models) {
  bottleneck::ClusteringConfig defaults;
  if (!models.empty()) defaults.alpha = segmentation::loadModelSet(models).alpha;
  try {
    return config::load(given, "the clustering", defaults);
  } catch (const config::ConfigError& e) {
    throw options::error(e.what());
  }
}

/// Nothing if only help was asked for.
std::optional<Arguments> parseArguments(int argc, char** argv) {
  Arguments arguments;
  std::string alpha, delta, top_k, prior, normaliser;
  options::options_description description(
      "Clusters the SEGMENTS layer (OBJECTS where that is absent) of a spark_dsg JSON scene "
      "graph,\n"
      "version 1.0 or 1.1, and writes the graph with one object per cluster.\n"
      "usage: cluster_scene_graph --input dsg.json --tasks tasks.yaml --output out.json [options]\n"
      "options");
  description.add_options()("help,h", "print this")(
      "input", tools::pathOption(arguments.input)->required(), "scene graph to read")(
      "tasks", tools::pathOption(arguments.tasks)->required(),
      "task file (YAML), with an embedding per task unless there is --models")(
      "output", tools::pathOption(arguments.output)->required(), "scene graph to write")(
      "alpha", options::value(&alpha),
      "score of the null task (default: the model set's, or 0.23)")(
      "delta", options::value(&delta),
      "threshold of the normaliser (default 1e-5; size_invariant: 0.03 bits)")(
      "top-k", options::value(&top_k), "tasks kept per primitive, null included (default 2)")(
      "prior", options::value(&prior), "uniform or marginal (default uniform)")(
      "normaliser", options::value(&normaliser), "paper or size_invariant (default paper)")(
      "reach", options::value(&arguments.reach),
      "primitives are neighbours where their boxes overlap, each as much higher and deeper as this "
      "share of its middle side (default 0, as in the paper; the chain's object_reach is 0.1)")(
      "tape", tools::pathOption(arguments.tape),
      "file to write I(X;Y), the accepted merges and the partition to (JSON)")(
      "models", tools::pathOption(arguments.models),
      "model set (YAML) whose text encoder encodes tasks that have no embedding");
  if (!tools::parseOptions(argc, argv, description)) return std::nullopt;
  if (!(arguments.reach >= 0.0 && arguments.reach <= 1.0)) {
    throw options::error("--reach is " + std::to_string(arguments.reach) + ", expected 0 to 1");
  }
  const char* threshold = normaliser == "size_invariant" ? "delta_bits" : "delta";
  const std::pair<const char*, std::string> given[] = {{"alpha", alpha},
                                                       {threshold, delta},
                                                       {"top_k", top_k},
                                                       {"prior", prior},
                                                       {"normaliser", normaliser}};
  YAML::Node clustering(YAML::NodeType::Map);
  for (const auto& [name, text] : given) {
    if (!text.empty()) clustering[name] = text;
  }
  arguments.config = makeConfig(clustering, arguments.models);
  return arguments;
}

scene_graph::TaskList readTasks(const Arguments& arguments) {
  scene_graph::TaskList tasks = scene_graph::loadTasks(arguments.tasks);
  if (tasks.size() == 0) {
    std::cerr << "task file '" << arguments.tasks << "' holds no task: there will be no objects\n";
  }
  if (tasks.hasEmbeddings() || tasks.size() == 0) return tasks;
  if (arguments.models.empty()) {
    throw std::invalid_argument("tasks '" + arguments.tasks + "': task '" + tasks.names.front() +
                                "' has no embedding; expected one per task, or --models");
  }
  const language::TextEncoder encoder(segmentation::loadModelSet(arguments.models), {});
  tasks.embeddings = encoder.encodeTasks(tasks.names);
  return tasks;
}

bottleneck::IncrementalClustering makeClustering(const Arguments& arguments,
                                                 const scene_graph::TaskList& tasks,
                                                 const scene_graph::SceneGraphFile& graph) {
  bottleneck::IncrementalClustering clustering(arguments.config,
                                               bottleneck::Adjacency::kBoxOverlap);
  clustering.setTasks(tasks.embeddings);
  for (const scene_graph::FilePrimitive& primitive : graph.primitives()) {
    try {
      clustering.insert(primitive.id, primitive.embedding,
                        bottleneck::extendUpAndDown(primitive.box, arguments.reach));
    } catch (const std::invalid_argument& e) {
      throw std::invalid_argument("scene graph '" + arguments.input + "': node " +
                                  scene_graph::describeNode(primitive.id) + ": " + e.what());
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

struct Clustered {
  std::vector<bottleneck::Cluster> clusters;
  double information_bits = 0.0;
  nlohmann::json tape;  ///< null unless it is asked for
};

// The clustering, which holds a copy of all embeddings, is gone before objects are made.
Clustered cluster(const Arguments& arguments, const scene_graph::TaskList& tasks,
                  const scene_graph::SceneGraphFile& graph) {
  auto clustering = makeClustering(arguments, tasks, graph);
  Clustered clustered{clustering.clusters(), clustering.information(), {}};
  if (!arguments.tape.empty()) clustered.tape = makeTape(clustering);
  return clustered;
}

void run(const Arguments& arguments) {
  const scene_graph::TaskList tasks = readTasks(arguments);
  scene_graph::SceneGraphFile graph(arguments.input, tasks.embeddings.cols());
  const Clustered clustered = cluster(arguments, tasks, graph);
  graph.replaceObjects(clustered.clusters, tasks.names);
  writeFileAtomically(arguments.output, [&](std::ostream& out) { graph.write(out); });
  std::vector<WrittenFile> files{
      {arguments.output, formatCount(graph.primitives().size(), "primitive") + " in " +
                             formatCount(clustered.clusters.size(), "cluster")}};
  if (!arguments.tape.empty()) {
    writeFileAtomically(arguments.tape, [&](std::ostream& out) { out << clustered.tape << '\n'; });
    files.push_back({arguments.tape, formatCount(clustered.tape["merges"].size(), "merge")});
  }
  for (const std::string& note : graph.notes()) {
    std::cerr << "cluster_scene_graph: scene graph '" << arguments.input << "': " << note << '\n';
  }
  std::cout << describeWritten({}, files) << ", " << graph.numLeftNodes()
            << (graph.numLeftNodes() == 1 ? " node" : " nodes")
            << " left as in the file, I(X;Y) = " << clustered.information_bits << " bits\n";
}

}  // namespace

int main(int argc, char** argv) {
  return tools::runProgram("cluster_scene_graph", argc, argv, parseArguments, run);
}
