// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/scene_graph_file.h"

#include <algorithm>
#include <thread>
#include <utility>

#include "node_attributes.h"
#include "scene_graph_content.h"
#include "task_scene_graph/core/parallel.h"

namespace tsg::scene_graph {
namespace {

constexpr int kSymbolShift = 56;  // a node id is a letter and a number

void requireUtf8(const std::vector<std::string>& task_names) {
  for (std::size_t i = 0; i < task_names.size(); ++i) {
    try {
      nlohmann::json(task_names[i]).dump();
    } catch (const nlohmann::json::exception&) {
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

int countThreads() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

std::string describeNode(NodeKey id) {
  const char letter = static_cast<char>(id >> kSymbolShift);
  const NodeKey index = id & ((NodeKey{1} << kSymbolShift) - 1);
  const bool is_symbol = letter >= '!' && letter <= '~';
  const std::string number = std::to_string(id);
  return is_symbol ? letter + std::to_string(index) + " (" + number + ")" : number;
}

void SceneGraphFile::Content::read(Eigen::Index embedding_size) {
  json = JsonText::read(path);
  graph = json->readObject(json->root());
  const JsonSpan node_list = requireList("nodes");
  const JsonSpan edge_list = requireList("edges");
  head = readFields(*json, graph, {"layer_names", "layer_keys", "layer_ids"});
  layers = readLayers(head);
  readNodes(node_list);
  readEdges(edge_list);
  const bool is_given = embedding_size > 0;
  leaveOtherSizes(is_given ? embedding_size : findCommonestSize(primitives), is_given);
  requirePrimitives();
}

JsonSpan SceneGraphFile::Content::requireList(const char* name) const {
  const JsonSpan* list = graph.find(name);
  if (list != nullptr && json->isArray(*list)) return *list;
  throw std::runtime_error("has no list of '" + std::string(name) +
                           "'; expected a spark_dsg scene graph");
}

// Nodes of dynamic layers share the numbers of static ones: 1.0 gives them a timestamp, 1.1 a
// partition.
NodeRecord SceneGraphFile::Content::readNode(JsonSpan text) const {
  const JsonObject fields = json->readObject(text);
  NodeRecord node;
  node.text = text;
  if (const JsonSpan* attributes = fields.find("attributes")) node.attributes = *attributes;
  const auto readField = [&](const char* name) -> std::optional<std::int64_t> {
    const JsonSpan* value = fields.find(name);
    return value == nullptr ? std::nullopt : json->readInteger(*value);
  };
  if (const JsonSpan* id = fields.find("id")) node.id = json->readUnsigned(*id);
  const auto layer = readField("layer");
  const bool has_partition = fields.find("partition") != nullptr;
  const auto partition = has_partition ? readField("partition") : 0;
  node.is_complete = node.id && layer && partition;
  const bool is_static = partition == 0 && fields.find("timestamp") == nullptr;
  if (is_static && layer) node.layer = layer;
  return node;
}

void SceneGraphFile::Content::readNodes(JsonSpan list) {
  const std::vector<JsonSpan> texts = json->readArray(list);
  nodes.resize(texts.size());
  parallelFor(texts.size(), countThreads(), [&](std::size_t i) { nodes[i] = readNode(texts[i]); });
  has_segments = std::any_of(nodes.begin(), nodes.end(), [&](const NodeRecord& node) {
    return node.isInLayer(layers.segments);
  });
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const bool is_clustered = nodes[i].isInLayer(clusteredLayer());
    if (is_clustered && nodes[i].id) {
      places.push_back(i);
    } else if (is_clustered) {
      left_nodes.add("entry " + std::to_string(i) + " of 'nodes' has no 'id' that is a number");
    } else if (!nodes[i].is_complete) {
      no_nodes.add("entry " + std::to_string(i));
    }
  }
  readPrimitives(places);
}

JsonObject SceneGraphFile::Content::readAttributes(const NodeRecord& node) const {
  return node.attributes ? json->readObject(*node.attributes) : JsonObject();
}

FilePrimitive SceneGraphFile::Content::readPrimitive(const NodeRecord& node) const {
  const JsonObject attributes = readAttributes(node);
  if (attributes.fields().empty()) throw std::runtime_error("has no 'attributes'");
  const auto solid = readFields(*json, attributes, {"position", "bounding_box"});
  FilePrimitive primitive;
  primitive.id = *node.id;
  primitive.position_m = readPosition(solid);
  primitive.embedding = readEmbedding(*json, attributes);
  primitive.box = readBox(solid);
  return primitive;
}

void SceneGraphFile::Content::readPrimitives(const std::vector<std::size_t>& places) {
  std::vector<FilePrimitive> read(places.size());
  std::vector<std::string> errors(places.size());
  parallelFor(places.size(), countThreads(), [&](std::size_t i) {
    try {
      read[i] = readPrimitive(nodes[places[i]]);
    } catch (const std::runtime_error& e) {
      errors[i] = e.what();
    }
  });
  for (std::size_t i = 0; i < places.size(); ++i) {
    const NodeKey id = *nodes[places[i]].id;
    const bool is_read = errors[i].empty();
    if (is_read && place_of.emplace(id, places[i]).second) {
      primitives.push_back(std::move(read[i]));
    } else {
      left_nodes.add(describeNode(id) + ' ' + (is_read ? "is there already" : errors[i]));
    }
  }
}

void SceneGraphFile::Content::readEdges(JsonSpan list) {
  const std::unordered_set<NodeKey> ids = listIds();
  const std::vector<JsonSpan> texts = json->readArray(list);
  std::optional<bool> has_metadata;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const JsonObject fields = json->readObject(texts[i]);
    const JsonSpan* info = fields.find("info");
    if (!has_metadata && info != nullptr && json->isObject(*info)) {
      const JsonObject attributes = json->readObject(*info);
      has_metadata = attributes.find("metadata") != nullptr;
    }
    const JsonSpan* source = fields.find("source");
    const JsonSpan* target = fields.find("target");
    const auto from = source == nullptr ? std::nullopt : json->readUnsigned(*source);
    const auto to = target == nullptr ? std::nullopt : json->readUnsigned(*target);
    if (!from || !to) {
      left_edges.add("entry " + std::to_string(i) + " of 'edges' has no 'source' and 'target'");
    } else if (ids.count(*from) == 0 || ids.count(*to) == 0) {
      left_edges.add(describeNode(*from) + " to " + describeNode(*to));
    } else {
      edges.push_back({texts[i], *from, *to});
    }
  }
  has_edge_metadata = has_metadata.value_or(graph.find("layer_keys") != nullptr);
}

std::unordered_set<NodeKey> SceneGraphFile::Content::listIds() const {
  std::unordered_set<NodeKey> ids;
  for (const NodeRecord& node : nodes) {
    if (node.id && node.is_kept) ids.insert(*node.id);
  }
  return ids;
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

std::unordered_set<NodeKey> SceneGraphFile::nodeIds() const { return content_->listIds(); }

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
  add(content.json->numOddNumbers(), " number", " numbers",
      " that JSON does not know (NaN, Infinity, 1e999) taken as null");
  return lines;
}

void SceneGraphFile::replaceObjects(const std::vector<Cluster>& clusters,
                                    const std::vector<std::string>& task_names) {
  requireUtf8(task_names);
  content_->namingTheFile([&] { content_->replaceObjects(clusters, task_names); });
}

void SceneGraphFile::write(std::ostream& out) const { content_->write(out); }

}  // namespace tsg::scene_graph
