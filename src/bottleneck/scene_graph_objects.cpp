// SPDX-License-Identifier: BSD-3-Clause
// How the clusters' objects come into a scene graph file.
#include <algorithm>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "node_attributes.h"
#include "scene_graph_content.h"
#include "task_scene_graph/core/point_index.h"

namespace tsg::bottleneck {
namespace {

using nlohmann::json;

NodeKey makeNodeId(char letter, NodeKey index) {
  constexpr int kSymbolShift = 56;
  return (static_cast<NodeKey>(letter) << kSymbolShift) | index;
}

/// By smallest primitive.
std::vector<Cluster> sortClusters(std::vector<Cluster> clusters) {
  std::sort(clusters.begin(), clusters.end(),
            [](const Cluster& a, const Cluster& b) { return a.members[0] < b.members[0]; });
  return clusters;
}

}  // namespace

json SceneGraphFile::Content::makeObject(const Cluster& cluster, NodeKey id,
                                         const std::vector<std::string>& task_names) {
  std::vector<const json*> members;
  for (const NodeKey member : cluster.members) {
    members.push_back(&nodes()[place_of.at(member)].at("attributes"));
  }
  json object = nodes()[place_of.at(cluster.members.front())];
  object["id"] = id;
  object["layer"] = layers.objects;
  std::vector<BadMesh> bad_meshes;
  json& attributes = object["attributes"] = mergeAttributes(members, bad_meshes);
  for (const BadMesh& bad : bad_meshes) {
    left_meshes.add(describeNode(cluster.members[bad.member]) + ": " + bad.what);
  }
  const bool is_relevant = cluster.task > 0;
  attributes["name"] =
      is_relevant ? task_names.at(static_cast<std::size_t>(cluster.task - 1)) : std::string();
  if (is_relevant) attributes["semantic_label"] = cluster.task - 1;
  return object;
}

std::vector<json> SceneGraphFile::Content::makeObjects(const std::vector<Cluster>& clusters,
                                                       const std::vector<std::string>& task_names) {
  std::unordered_set<NodeKey> kept_ids;
  for (const json& node : nodes()) {
    const auto id = readNodeId(node, "id");
    if (id && !isInLayer(node, layers.objects)) kept_ids.insert(*id);
  }
  std::vector<json> objects;
  NodeKey next_index = 0;
  for (const Cluster& cluster : clusters) {
    NodeKey id = cluster.members.front();
    if (has_segments) {
      do id = makeNodeId('O', next_index++);
      while (kept_ids.count(id) > 0);
    }
    objects.push_back(makeObject(cluster, id, task_names));
  }
  return objects;
}

// All objects where segments are clustered; else the objects that were.
void SceneGraphFile::Content::removeReplaced() {
  std::vector<bool> is_primitive(nodes().size(), false);
  for (const auto& [id, place] : place_of) is_primitive[place] = true;
  json kept = json::array();
  for (std::size_t i = 0; i < is_primitive.size(); ++i) {
    json& node = nodes()[i];
    const bool is_replaced = has_segments ? isInLayer(node, layers.objects) : is_primitive[i];
    if (!is_replaced) kept.push_back(std::move(node));
  }
  nodes() = std::move(kept);
}

std::unordered_set<NodeKey> SceneGraphFile::Content::listIds() const {
  std::unordered_set<NodeKey> ids;
  for (const json& node : graph.at("nodes")) {
    if (const auto id = readNodeId(node, "id")) ids.insert(*id);
  }
  return ids;
}

// Edges of nodes that are no more go to their heirs; those without an heir go.
void SceneGraphFile::Content::moveEdges(const std::map<NodeKey, NodeKey>& heirs,
                                        const std::unordered_set<NodeKey>& former_ids) {
  const std::unordered_set<NodeKey> present = listIds();
  const auto findHeir = [&](NodeKey id) {
    const auto heir = heirs.find(id);
    return heir == heirs.end() ? id : heir->second;
  };
  std::set<std::pair<NodeKey, NodeKey>> seen;
  json kept = json::array();
  for (std::size_t i = 0; i < graph["edges"].size(); ++i) {
    json& edge = graph["edges"][i];
    const auto source = readNodeId(edge, "source");
    const auto target = readNodeId(edge, "target");
    if (!source || !target) {
      left_edges.add("entry " + std::to_string(i) + " of 'edges' has no 'source' and 'target'");
      continue;
    }
    if (former_ids.count(*source) == 0 || former_ids.count(*target) == 0) {
      left_edges.add(describeNode(*source) + " to " + describeNode(*target));
      continue;
    }
    const std::pair<NodeKey, NodeKey> ends{findHeir(*source), findHeir(*target)};
    const bool is_kept = ends.first != ends.second && present.count(ends.first) > 0 &&
                         present.count(ends.second) > 0 && seen.insert(ends).second;
    if (!is_kept) continue;
    edge["source"] = ends.first;
    edge["target"] = ends.second;
    kept.push_back(std::move(edge));
  }
  graph["edges"] = std::move(kept);
}

// A node has one parent: what was the parent of segments becomes that of their object.
std::map<std::size_t, NodeKey> SceneGraphFile::Content::detachSegments(
    const std::vector<Cluster>& clusters) {
  std::unordered_map<NodeKey, std::size_t> object_of;
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
  return parents;
}

// Ids of the places that have a position, and these.
std::pair<std::vector<NodeKey>, std::vector<Eigen::Vector3d>>
SceneGraphFile::Content::listPlaces() {
  std::vector<NodeKey> ids;
  std::vector<Eigen::Vector3d> positions_m;
  for (const json& node : nodes()) {
    const auto id = readNodeId(node, "id");
    if (!id || !isInLayer(node, layers.places)) continue;
    try {
      positions_m.push_back(readPosition(node.value("attributes", json::object())));
      ids.push_back(*id);
    } catch (const std::runtime_error& e) {
      left_places.add(describeNode(*id) + ' ' + e.what());
    }
  }
  return {ids, positions_m};
}

void SceneGraphFile::Content::attachObjects(const std::vector<json>& objects,
                                            const std::vector<Cluster>& clusters) {
  const std::map<std::size_t, NodeKey> parents = detachSegments(clusters);
  const auto [place_ids, positions_m] = listPlaces();
  const PointIndex places(positions_m);
  json edge = makeGraphEdge(graph, 0, 0);
  const auto addEdge = [&](NodeKey parent, NodeKey child) {
    edge["source"] = parent;
    edge["target"] = child;
    graph["edges"].push_back(edge);
  };
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const auto id = objects[i].at("id").get<NodeKey>();
    const auto parent = parents.find(i);
    if (parent != parents.end()) {
      addEdge(parent->second, id);
    } else if (!places.isEmpty()) {
      addEdge(place_ids[places.findNearest(readPosition(objects[i].at("attributes")))], id);
    }
    for (const NodeKey member : clusters[i].members) addEdge(id, member);
  }
}

void SceneGraphFile::Content::replaceObjects(const std::vector<Cluster>& clusters,
                                             const std::vector<std::string>& task_names) {
  const std::vector<Cluster> sorted = sortClusters(clusters);
  const std::vector<json> objects = makeObjects(sorted, task_names);
  const std::unordered_set<NodeKey> former_ids = listIds();
  removeReplaced();
  std::map<NodeKey, NodeKey> heirs;
  if (!has_segments) {
    for (const json& object : objects) nodes().push_back(object);
    for (const Cluster& cluster : sorted) {
      for (const NodeKey member : cluster.members) heirs[member] = cluster.members.front();
    }
  }
  moveEdges(heirs, former_ids);
  listObjectLayer(layers.objects, graph);
  if (!has_segments) return;
  attachObjects(objects, sorted);
  for (const json& object : objects) nodes().push_back(object);
}

}  // namespace tsg::bottleneck
