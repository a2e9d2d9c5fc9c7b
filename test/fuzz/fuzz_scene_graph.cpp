// SPDX-License-Identifier: BSD-3-Clause
// Scene graph files, as cluster_scene_graph reads, clusters and writes them.
#include <iterator>
#include <sstream>

#include "../unit/scene_graph/scene_graph_samples.h"
#include "fuzzer.h"
#include "task_scene_graph/bottleneck/clustering.h"
#include "task_scene_graph/scene_graph/scene_graph_file.h"

namespace {

namespace fuzz = tsg::fuzz;
namespace bottleneck = tsg::bottleneck;
namespace files = tsg::scene_graph;
using nlohmann::json;

json makeObjectsOnly(json graph) {
  for (auto& node : graph["nodes"]) {
    if (node["layer"] == 1) node["layer"] = 2;
  }
  return graph;
}

std::string make(fuzz::Mutator& mutator) {
  using files::FileForm;
  static const std::vector<json> corpus = [] {
    std::vector<json> graphs;
    for (const FileForm form : {FileForm::kClio, FileForm::kCurrent}) {
      graphs.push_back(files::makeSampleGraph(form, 3));
      graphs.push_back(makeObjectsOnly(graphs.back()));
    }
    return graphs;
  }();
  return fuzz::makeJson(mutator, mutator.pickFrom(corpus));
}

/// Merges whatever touches.
std::string cluster(files::SceneGraphFile& file) {
  bottleneck::ClusteringConfig config;
  config.delta = 1.0;
  bottleneck::IncrementalClustering clustering(config, bottleneck::Adjacency::kBoxOverlap);
  clustering.setTasks((tsg::EmbeddingMatrix(1, 3) << 1.0F, 0.0F, 0.0F).finished());
  for (const auto& primitive : file.primitives()) {
    clustering.insert(primitive.id, primitive.embedding, primitive.box);
  }
  file.replaceObjects(clustering.clusters(), {"wash"});
  std::ostringstream out;
  file.write(out);
  return out.str();
}

void readInput(const std::string& path) {
  std::string written;
  {
    files::SceneGraphFile file(path, 3);
    written = cluster(file);
  }
  fuzz::writeFile(path, written);
  try {
    const files::SceneGraphFile again(path, 3);
  } catch (const std::exception& e) {
    throw std::logic_error(std::string("what was written cannot be read again: ") +
                           std::string(e.what()).substr(path.size()));
  }
}

}  // namespace

int main(int argc, char** argv) {
  return fuzz::runFuzzer(argc, argv,
                         fuzz::makeFileReader("scene_graph", "scene_graph.json", make, readInput));
}
