// SPDX-License-Identifier: BSD-3-Clause
// How the clusters' objects come into a scene graph file.
#include <algorithm>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "node_attributes.h"
#include "scene_graph_content.h"
#include "task_scene_graph/core/parallel.h"
#include "task_scene_graph/core/point_index.h"

namespace tsg::scene_graph {
namespace {

/// By smallest primitive.
std::vector<Cluster> sortClusters(std::vector<Cluster> clusters) {
  std::sort(clusters.begin(), clusters.end(),
            [](const Cluster& a, const Cluster& b) { return a.members[0] < b.members[0]; });
  return clusters;
}

FeatureForm readFeatureForm(const JsonText& json, const JsonObject& attributes) {
  const JsonSpan feature = *attributes.find("semantic_feature");
  if (json.isArray(feature)) return FeatureForm::kList;
  const JsonObject matrix = json.readObject(feature);
  const JsonSpan* rows = matrix.find("rows");
  return rows != nullptr && json.readUnsigned(*rows) == 1U ? FeatureForm::kRow
                                                           : FeatureForm::kColumn;
}

}  // namespace

std::vector<NodeKey> SceneGraphFile::Content::chooseIds(
    const std::vector<Cluster>& clusters) const {
  std::unordered_set<NodeKey> kept_ids;
  for (const NodeRecord& node : nodes) {
    if (node.id && !node.isInLayer(layers.objects)) kept_ids.insert(*node.id);
  }
  std::vector<NodeKey> ids;
  NodeKey next_index = 0;
  for (const Cluster& cluster : clusters) {
    NodeKey id = cluster.members.front();
    if (has_segments) {
      do id = makeNodeId('O', next_index++);
      while (kept_ids.count(id) > 0);
    }
    ids.push_back(id);
  }
  return ids;
}

// Attributes that are not those of the first member.
FieldTexts SceneGraphFile::Content::mergeMembers(const Cluster& cluster,
                                                 const PrimitiveUnion& whole,
                                                 std::vector<BadMesh>& bad_meshes) const {
  std::vector<JsonObject> members;
  for (const NodeKey member : cluster.members) {
    members.push_back(readAttributes(nodes[place_of.at(member)]));
  }
  FieldTexts fields = mergeAttributes(*json, members, whole.box(), whole.position_m(), bad_meshes);
  fields.emplace_back("semantic_feature", "");
  appendFeature(whole.embedding(), readFeatureForm(*json, members.front()), fields.back().second);
  return fields;
}

ObjectNode SceneGraphFile::Content::makeObject(const Cluster& cluster, NodeKey id,
                                               const std::string& task_name,
                                               std::vector<BadMesh>& bad_meshes) const {
  PrimitiveUnion whole;
  for (const NodeKey member : cluster.members) {
    const FilePrimitive& primitive = primitives[index_of.at(member)];
    whole.add(primitive.position_m, primitive.box, primitive.embedding);
  }
  FieldTexts fields;
  if (cluster.members.size() > 1) fields = mergeMembers(cluster, whole, bad_meshes);
  fields.emplace_back("name", quoteJson(task_name));
  if (cluster.task > 0) fields.emplace_back("semantic_label", std::to_string(cluster.task - 1));
  const NodeRecord& first = nodes[place_of.at(cluster.members.front())];
  const FieldTexts node = {{"id", std::to_string(id)},
                           {"layer", std::to_string(layers.objects)},
                           {"attributes", replaceFields(*json, readAttributes(first), fields)}};
  return {id, whole.position_m(), replaceFields(*json, json->readObject(first.text), node)};
}

void SceneGraphFile::Content::makeObjects(const std::vector<Cluster>& clusters,
                                          const std::vector<std::string>& task_names) {
  for (std::size_t i = 0; i < primitives.size(); ++i) index_of[primitives[i].id] = i;
  const std::vector<NodeKey> ids = chooseIds(clusters);
  std::vector<std::vector<BadMesh>> bad_meshes(clusters.size());
  objects.resize(clusters.size());
  parallelFor(clusters.size(), countThreads(), [&](std::size_t i) {
    const auto task = static_cast<std::size_t>(clusters[i].task);
    objects[i] =
        makeObject(clusters[i], ids[i], task > 0 ? task_names.at(task - 1) : "", bad_meshes[i]);
  });
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    for (const BadMesh& bad : bad_meshes[i]) {
      left_meshes.add(describeNode(clusters[i].members[bad.member]) + ": " + bad.what);
    }
  }
}

// All objects where segments are clustered; else the objects that were.
void SceneGraphFile::Content::removeReplaced() {
  if (has_segments) {
    for (NodeRecord& node : nodes) node.is_kept = !node.isInLayer(layers.objects);
  } else {
    for (const auto& [id, place] : place_of) nodes[place].is_kept = false;
  }
}

// Edges of nodes that are no more go to their heirs; those without an heir go.
void SceneGraphFile::Content::moveEdges(const std::vector<Cluster>& clusters) {
  std::unordered_map<NodeKey, NodeKey> heirs;
  std::unordered_set<NodeKey> present = listIds();
  for (const Cluster& cluster : has_segments ? std::vector<Cluster>() : clusters) {
    present.insert(cluster.members.front());
    for (const NodeKey member : cluster.members) heirs[member] = cluster.members.front();
  }
  const auto findHeir = [&](NodeKey id) {
    const auto heir = heirs.find(id);
    return heir == heirs.end() ? id : heir->second;
  };
  std::set<std::pair<NodeKey, NodeKey>> seen;
  std::vector<EdgeRecord> kept;
  for (EdgeRecord edge : edges) {
    const std::pair<NodeKey, NodeKey> ends{findHeir(edge.source), findHeir(edge.target)};
    const bool is_kept = ends.first != ends.second && present.count(ends.first) > 0 &&
                         present.count(ends.second) > 0 && seen.insert(ends).second;
    if (!is_kept) continue;
    edge.is_moved = ends != std::pair(edge.source, edge.target);
    std::tie(edge.source, edge.target) = ends;
    kept.push_back(edge);
  }
  edges = std::move(kept);
}

// A node has one parent: what was the parent of segments becomes that of their object.
std::map<std::size_t, NodeKey> SceneGraphFile::Content::detachSegments(
    const std::vector<Cluster>& clusters) {
  std::unordered_map<NodeKey, std::size_t> object_of;
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    for (const NodeKey member : clusters[i].members) object_of[member] = i;
  }
  std::map<std::size_t, NodeKey> parents;
  std::vector<EdgeRecord> kept;
  for (const EdgeRecord& edge : edges) {
    const bool is_source = object_of.count(edge.source) > 0;
    if (is_source == (object_of.count(edge.target) > 0)) {
      kept.push_back(edge);
    } else {
      parents.emplace(object_of.at(is_source ? edge.source : edge.target),
                      is_source ? edge.target : edge.source);
    }
  }
  edges = std::move(kept);
  return parents;
}

// Ids of the places that have a position, and these.
std::pair<std::vector<NodeKey>, std::vector<Eigen::Vector3d>>
SceneGraphFile::Content::listPlaces() {
  std::vector<NodeKey> ids;
  std::vector<Eigen::Vector3d> positions_m;
  for (const NodeRecord& node : nodes) {
    if (!node.id || !node.is_kept || !node.isInLayer(layers.places)) continue;
    try {
      positions_m.push_back(readPosition(readFields(*json, readAttributes(node), {"position"})));
      ids.push_back(*node.id);
    } catch (const std::runtime_error& e) {
      left_places.add(describeNode(*node.id) + ' ' + e.what());
    }
  }
  return {ids, positions_m};
}

void SceneGraphFile::Content::attachObjects(const std::vector<Cluster>& clusters) {
  const std::map<std::size_t, NodeKey> parents = detachSegments(clusters);
  const auto [place_ids, positions_m] = listPlaces();
  const PointIndex places(positions_m);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const auto parent = parents.find(i);
    if (parent != parents.end()) {
      new_edges.push_back({parent->second, objects[i].id});
    } else if (!places.isEmpty()) {
      new_edges.push_back({place_ids[places.findNearest(objects[i].position_m)], objects[i].id});
    }
    for (const NodeKey member : clusters[i].members) new_edges.push_back({objects[i].id, member});
  }
}

void SceneGraphFile::Content::replaceObjects(const std::vector<Cluster>& clusters,
                                             const std::vector<std::string>& task_names) {
  const std::vector<Cluster> sorted = sortClusters(clusters);
  makeObjects(sorted, task_names);
  removeReplaced();
  moveEdges(sorted);
  listObjectLayer(layers.objects, head);
  if (has_segments) attachObjects(sorted);
}

}  // namespace tsg::scene_graph
