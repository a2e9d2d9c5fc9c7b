// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/bottleneck/scene_graph_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <stdexcept>

#include "node_attributes.h"

namespace tsg::bottleneck {
namespace {

using nlohmann::json;

// Static layers have fixed numbers; 1.1 also lists them by name.
constexpr int kSegmentLayer = 1;
constexpr int kObjectLayer = 2;
constexpr int kPlaceLayer = 3;
constexpr int kSymbolShift = 56;  // a node id is a letter and a number

NodeKey makeNodeId(char letter, NodeKey index) {
  return (static_cast<NodeKey>(letter) << kSymbolShift) | index;
}

int findLayer(const json& graph, const char* name, int fallback) {
  const auto names = graph.find("layer_names");
  if (names == graph.end() || !names->contains(name)) return fallback;
  const json& layer = names->at(name);
  return layer.is_object() ? layer.at("layer").get<int>() : layer.get<int>();
}

// Nodes of dynamic layers share the number: 1.0 gives them a timestamp, 1.1 a partition.
bool isIn(const json& node, int layer) {
  return node.at("layer") == layer && node.value("partition", 0) == 0 &&
         !node.contains("timestamp");
}

json readJson(const std::string& path) {
  std::ifstream in(path);
  if (!in) {
    throw std::runtime_error("scene graph '" + path + "': " + std::strerror(errno) +
                             "; expected a spark_dsg JSON file");
  }
  try {
    return json::parse(in);
  } catch (const json::parse_error& e) {
    throw std::runtime_error("scene graph '" + path + "' is not JSON: " + e.what());
  }
}

FilePrimitive readPrimitive(const json& node) {
  const auto id = node.at("id").get<NodeKey>();
  try {
    const json& attributes = node.at("attributes");
    return {id, readEmbedding(attributes), readBox(attributes)};
  } catch (const std::exception& e) {
    throw std::runtime_error("node " + describeNode(id) + " " + e.what());
  }
}

}  // namespace

struct SceneGraphFile::Content {
  json graph;
  int object_layer = kObjectLayer;
  int place_layer = kPlaceLayer;
  bool has_segments = false;
  std::vector<FilePrimitive> primitives;

  void read();
  void listObjectLayer();
  std::map<NodeKey, const json*> indexNodes() const;
  json makeObject(const Cluster& cluster, NodeKey id, const std::map<NodeKey, const json*>& nodes,
                  const std::vector<std::string>& task_names) const;
  json makeEdge(NodeKey parent, NodeKey child) const;
  std::optional<NodeKey> findNearestPlace(const json& object) const;
  void removeNodes(const std::set<NodeKey>& ids);
  void moveEdges(const std::map<NodeKey, NodeKey>& heirs);
  void attachObjects(const std::vector<json>& objects, const std::vector<Cluster>& clusters);
};

std::string describeNode(NodeKey id) {
  const char letter = static_cast<char>(id >> kSymbolShift);
  const NodeKey index = id & ((NodeKey{1} << kSymbolShift) - 1);
  const bool is_symbol = letter >= '!' && letter <= '~';
  const std::string number = std::to_string(id);
  return is_symbol ? letter + std::to_string(index) + " (" + number + ")" : number;
}

void SceneGraphFile::Content::read() {
  if (!graph.is_object() || !graph.contains("nodes") || !graph.contains("edges")) {
    throw std::runtime_error("has no 'nodes' and 'edges'; expected a spark_dsg scene graph");
  }
  const int segment_layer = findLayer(graph, "SEGMENTS", kSegmentLayer);
  object_layer = findLayer(graph, "OBJECTS", kObjectLayer);
  place_layer = findLayer(graph, "PLACES", kPlaceLayer);
  const json& nodes = graph.at("nodes");
  has_segments = std::any_of(nodes.begin(), nodes.end(),
                             [&](const json& node) { return isIn(node, segment_layer); });
  for (const json& node : nodes) {
    if (isIn(node, has_segments ? segment_layer : object_layer)) {
      primitives.push_back(readPrimitive(node));
    }
  }
}

void SceneGraphFile::Content::listObjectLayer() {
  const bool has_keys = graph.contains("layer_keys");
  json& list = graph[has_keys ? "layer_keys" : "layer_ids"];
  const json key = has_keys ? json{{"layer", object_layer}, {"partition", 0}} : json(object_layer);
  if (std::find(list.begin(), list.end(), key) == list.end()) list.push_back(key);
  if (!graph.contains("layer_names") || graph["layer_names"].contains("OBJECTS")) return;
  const bool has_numbers =
      !graph["layer_names"].empty() && graph["layer_names"].begin()->is_number();
  graph["layer_names"]["OBJECTS"] =
      has_numbers ? json(object_layer) : json{{"layer", object_layer}, {"partition", 0}};
}

std::map<NodeKey, const json*> SceneGraphFile::Content::indexNodes() const {
  std::map<NodeKey, const json*> nodes;
  for (const json& node : graph.at("nodes")) nodes[node.at("id").get<NodeKey>()] = &node;
  return nodes;
}

json SceneGraphFile::Content::makeObject(const Cluster& cluster, NodeKey id,
                                         const std::map<NodeKey, const json*>& nodes,
                                         const std::vector<std::string>& task_names) const {
  std::vector<const json*> members;
  for (const NodeKey member : cluster.members) {
    members.push_back(&nodes.at(member)->at("attributes"));
  }
  json object = *nodes.at(cluster.members.front());
  object["id"] = id;
  object["layer"] = object_layer;
  json& attributes = object["attributes"] = mergeAttributes(members);
  const bool is_relevant = cluster.task > 0;
  attributes["name"] =
      is_relevant ? task_names.at(static_cast<std::size_t>(cluster.task - 1)) : std::string();
  if (is_relevant) attributes["semantic_label"] = cluster.task - 1;
  return object;
}

json SceneGraphFile::Content::makeEdge(NodeKey parent, NodeKey child) const {
  const json& edges = graph.at("edges");
  json info = {{"type", "EdgeAttributes"}, {"weight", 1.0}, {"weighted", false}};
  // Versions differ in what else an edge has to carry.
  const bool has_metadata =
      edges.empty() ? graph.contains("layer_keys") : edges.front().at("info").contains("metadata");
  if (has_metadata) info["metadata"] = json::object();
  return {{"source", parent}, {"target", child}, {"info", info}};
}

std::optional<NodeKey> SceneGraphFile::Content::findNearestPlace(const json& object) const {
  const Eigen::Vector3d position = readPosition(object.at("attributes"));
  std::optional<NodeKey> nearest;
  double smallest = std::numeric_limits<double>::infinity();
  for (const json& node : graph.at("nodes")) {
    if (!isIn(node, place_layer)) continue;
    const double distance = (readPosition(node.at("attributes")) - position).squaredNorm();
    if (distance >= smallest) continue;
    smallest = distance;
    nearest = node.at("id").get<NodeKey>();
  }
  return nearest;
}

void SceneGraphFile::Content::removeNodes(const std::set<NodeKey>& ids) {
  json kept = json::array();
  for (json& node : graph["nodes"]) {
    if (ids.count(node.at("id").get<NodeKey>()) == 0) kept.push_back(std::move(node));
  }
  graph["nodes"] = std::move(kept);
}

// Edges of nodes that are no more go to their heirs; those without an heir go.
void SceneGraphFile::Content::moveEdges(const std::map<NodeKey, NodeKey>& heirs) {
  std::set<NodeKey> present;
  for (const json& node : graph["nodes"]) present.insert(node.at("id").get<NodeKey>());
  const auto findHeir = [&](const json& id) {
    const auto heir = heirs.find(id.get<NodeKey>());
    return heir == heirs.end() ? id.get<NodeKey>() : heir->second;
  };
  std::set<std::pair<NodeKey, NodeKey>> seen;
  json kept = json::array();
  for (json& edge : graph["edges"]) {
    const NodeKey source = findHeir(edge.at("source"));
    const NodeKey target = findHeir(edge.at("target"));
    const bool is_kept = source != target && present.count(source) > 0 &&
                         present.count(target) > 0 && seen.emplace(source, target).second;
    if (!is_kept) continue;
    edge["source"] = source;
    edge["target"] = target;
    kept.push_back(std::move(edge));
  }
  graph["edges"] = std::move(kept);
}

// A node has one parent: what was the parent of segments becomes that of their object.
void SceneGraphFile::Content::attachObjects(const std::vector<json>& objects,
                                            const std::vector<Cluster>& clusters) {
  std::map<NodeKey, std::size_t> object_of;
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    for (const NodeKey member : clusters[i].members) object_of[member] = i;
  }
  std::map<std::size_t, NodeKey> parents;
  json kept = json::array();
  for (json& edge : graph["edges"]) {
    const auto source = edge.at("source").get<NodeKey>();
    const auto target = edge.at("target").get<NodeKey>();
    const bool is_source = object_of.count(source) > 0;
    if (is_source == (object_of.count(target) > 0)) {
      kept.push_back(std::move(edge));
    } else {
      parents.emplace(object_of.at(is_source ? source : target), is_source ? target : source);
    }
  }
  graph["edges"] = std::move(kept);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const auto id = objects[i].at("id").get<NodeKey>();
    const auto parent = parents.find(i);
    const std::optional<NodeKey> place =
        parent != parents.end() ? parent->second : findNearestPlace(objects[i]);
    if (place) graph["edges"].push_back(makeEdge(*place, id));
    for (const NodeKey member : clusters[i].members) {
      graph["edges"].push_back(makeEdge(id, member));
    }
  }
}

SceneGraphFile::SceneGraphFile(const std::string& path) : content_(std::make_unique<Content>()) {
  content_->graph = readJson(path);
  try {
    content_->read();
  } catch (const std::exception& e) {
    throw std::runtime_error("scene graph '" + path + "': " + e.what());
  }
}

SceneGraphFile::~SceneGraphFile() = default;
SceneGraphFile::SceneGraphFile(SceneGraphFile&&) noexcept = default;
SceneGraphFile& SceneGraphFile::operator=(SceneGraphFile&&) noexcept = default;

const std::vector<FilePrimitive>& SceneGraphFile::primitives() const {
  return content_->primitives;
}

void SceneGraphFile::replaceObjects(const std::vector<Cluster>& clusters,
                                    const std::vector<std::string>& task_names) {
  std::vector<Cluster> sorted = clusters;
  std::sort(sorted.begin(), sorted.end(),
            [](const Cluster& a, const Cluster& b) { return a.members[0] < b.members[0]; });
  const auto nodes = content_->indexNodes();
  std::set<NodeKey> removed;
  for (const auto& [id, node] : nodes) {
    if (isIn(*node, content_->object_layer)) removed.insert(id);
  }
  std::vector<json> objects;
  std::map<NodeKey, NodeKey> heirs;
  NodeKey next_index = 0;
  for (const Cluster& cluster : sorted) {
    NodeKey id = cluster.members.front();
    if (content_->has_segments) {
      do id = makeNodeId('O', next_index++);
      while (nodes.count(id) > 0 && removed.count(id) == 0);
    } else {
      for (const NodeKey member : cluster.members) heirs[member] = id;
    }
    objects.push_back(content_->makeObject(cluster, id, nodes, task_names));
  }
  content_->removeNodes(removed);
  json::array_t& list = content_->graph["nodes"].get_ref<json::array_t&>();
  if (!content_->has_segments) list.insert(list.end(), objects.begin(), objects.end());
  content_->moveEdges(heirs);
  content_->listObjectLayer();
  if (!content_->has_segments) return;
  content_->attachObjects(objects, sorted);
  list.insert(list.end(), objects.begin(), objects.end());
}

void SceneGraphFile::write(std::ostream& out) const { out << content_->graph << '\n'; }

}  // namespace tsg::bottleneck
