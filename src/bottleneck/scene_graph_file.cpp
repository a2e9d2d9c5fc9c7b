// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/bottleneck/scene_graph_file.h"

#include <algorithm>
#include <ostream>
#include <utility>

#include "graph_json.h"
#include "node_attributes.h"
#include "scene_graph_content.h"

namespace tsg::bottleneck {
namespace {

using nlohmann::json;

constexpr int kSymbolShift = 56;  // a node id is a letter and a number

void requireList(const json& graph, const char* name) {
  const auto list = graph.find(name);
  if (list != graph.end() && list->is_array()) return;
  throw std::runtime_error("has no list of '" + std::string(name) +
                           "'; expected a spark_dsg scene graph");
}

void requireUtf8(const std::vector<std::string>& task_names) {
  for (std::size_t i = 0; i < task_names.size(); ++i) {
    try {
      json(task_names[i]).dump();
    } catch (const json::exception&) {
      throw std::invalid_argument("the name of task " + std::to_string(i + 1) +
                                  " is not valid UTF-8, as JSON needs it; convert the task file");
    }
  }
}

Eigen::Index findCommonestSize(const std::vector<FilePrimitive>& primitives) {
  std::map<Eigen::Index, std::size_t> counts;
  Eigen::Index commonest = 0;
  for (const FilePrimitive& primitive : primitives) {
    const Eigen::Index size = primitive.embedding.size();
    if (++counts[size] > counts[commonest]) commonest = size;
  }
  return commonest;
}

}  // namespace

std::string describeNode(NodeKey id) {
  const char letter = static_cast<char>(id >> kSymbolShift);
  const NodeKey index = id & ((NodeKey{1} << kSymbolShift) - 1);
  const bool is_symbol = letter >= '!' && letter <= '~';
  const std::string number = std::to_string(id);
  return is_symbol ? letter + std::to_string(index) + " (" + number + ")" : number;
}

void SceneGraphFile::Content::read(Eigen::Index embedding_size) {
  JsonFile file = readJsonFile(path);
  graph = std::move(file.content);
  num_odd_numbers = file.num_odd_numbers;
  requireList(graph, "nodes");
  requireList(graph, "edges");
  layers = readLayers(graph);
  readNodes();
  const bool is_given = embedding_size > 0;
  leaveOtherSizes(is_given ? embedding_size : findCommonestSize(primitives), is_given);
  requirePrimitives();
}

void SceneGraphFile::Content::readNodes() {
  const json& list = nodes();
  has_segments = std::any_of(list.begin(), list.end(),
                             [&](const json& node) { return isInLayer(node, layers.segments); });
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (isInLayer(list[i], clusteredLayer())) {
      readPrimitive(i);
    } else if (!isNode(list[i])) {
      no_nodes.add("entry " + std::to_string(i));
    }
  }
}

void SceneGraphFile::Content::readPrimitive(std::size_t place) {
  const json& node = nodes()[place];
  const auto id = readNodeId(node, "id");
  if (!id) {
    left_nodes.add("entry " + std::to_string(place) + " of 'nodes' has no 'id' that is a number");
    return;
  }
  try {
    const auto attributes = node.find("attributes");
    if (attributes == node.end() || !attributes->is_object()) {
      throw std::runtime_error("has no 'attributes'");
    }
    readPosition(*attributes);
    const FilePrimitive primitive{*id, readEmbedding(*attributes), readBox(*attributes)};
    if (!place_of.emplace(*id, place).second) throw std::runtime_error("is there already");
    primitives.push_back(primitive);
  } catch (const std::runtime_error& e) {
    left_nodes.add(describeNode(*id) + ' ' + e.what());
  }
}

void SceneGraphFile::Content::leaveOtherSizes(Eigen::Index expected, bool is_tasks) {
  const auto leave = [&](const FilePrimitive& primitive) {
    const Eigen::Index size = primitive.embedding.size();
    if (size == expected) return false;
    left_nodes.add(describeNode(primitive.id) + " has an embedding of " + std::to_string(size) +
                   " numbers, expected " + (is_tasks ? "the tasks' " : "the others' ") +
                   std::to_string(expected));
    place_of.erase(primitive.id);
    return true;
  };
  primitives.erase(std::remove_if(primitives.begin(), primitives.end(), leave), primitives.end());
}

void SceneGraphFile::Content::requirePrimitives() const {
  if (!primitives.empty() || left_nodes.count() == 0) return;
  throw std::runtime_error("has no node that can be clustered among the " +
                           std::to_string(left_nodes.count()) + " of the layer " +
                           (has_segments ? "SEGMENTS" : "OBJECTS") + ": " + left_nodes.listItems());
}

SceneGraphFile::SceneGraphFile(const std::string& path, Eigen::Index embedding_size)
    : content_(std::make_unique<Content>()) {
  content_->path = path;
  content_->namingTheFile([&] { content_->read(embedding_size); });
}

SceneGraphFile::~SceneGraphFile() = default;
SceneGraphFile::SceneGraphFile(SceneGraphFile&&) noexcept = default;
SceneGraphFile& SceneGraphFile::operator=(SceneGraphFile&&) noexcept = default;

const std::vector<FilePrimitive>& SceneGraphFile::primitives() const {
  return content_->primitives;
}

std::size_t SceneGraphFile::numLeftNodes() const { return content_->left_nodes.count(); }

std::vector<std::string> SceneGraphFile::notes() const {
  const Content& content = *content_;
  std::vector<std::string> lines;
  const auto add = [&](std::size_t count, const char* singular, const char* plural,
                       const std::string& rest) {
    if (count > 0) lines.push_back(std::to_string(count) + (count == 1 ? singular : plural) + rest);
  };
  const FileNote& nodes = content.left_nodes;
  add(nodes.count(), "", "",
      std::string(" of the nodes to be clustered (layer ") +
          (content.has_segments ? "SEGMENTS" : "OBJECTS") +
          ") left as in the file: " + nodes.listItems());
  add(content.no_nodes.count(), " entry", " entries",
      " of 'nodes' whose 'id', 'layer' or 'partition' is no whole number left as in the file: " +
          content.no_nodes.listItems());
  add(content.left_meshes.count(), " mesh", " meshes",
      " not readable, left out of the node's object: " + content.left_meshes.listItems());
  add(content.left_edges.count(), " edge", " edges",
      " of nodes that are not there left out: " + content.left_edges.listItems());
  add(content.left_places.count(), " place", " places",
      " without a position, no object's parent: " + content.left_places.listItems());
  add(content.num_odd_numbers, " number", " numbers",
      " that JSON does not know (NaN, Infinity, 1e999) taken as null");
  return lines;
}

void SceneGraphFile::replaceObjects(const std::vector<Cluster>& clusters,
                                    const std::vector<std::string>& task_names) {
  requireUtf8(task_names);
  content_->namingTheFile([&] { content_->replaceObjects(clusters, task_names); });
}

void SceneGraphFile::write(std::ostream& out) const { out << content_->graph << '\n'; }

}  // namespace tsg::bottleneck
