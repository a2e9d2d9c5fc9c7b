// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "file_notes.h"
#include "graph_layers.h"
#include "json_text.h"
#include "node_attributes.h"
#include "spark_dsg_format.h"
#include "task_scene_graph/scene_graph/primitive_union.h"
#include "task_scene_graph/scene_graph/scene_graph_file.h"

namespace tsg::scene_graph {

/// An entry of `nodes`.
struct NodeRecord {
  JsonSpan text;
  std::optional<JsonSpan> attributes;
  std::optional<NodeKey> id;
  std::optional<std::int64_t> layer;  ///< of the static layers
  bool is_complete = false;           ///< id, layer and partition are whole numbers
  bool is_kept = true;                ///< else an object takes its place

  bool isInLayer(int number) const { return layer && *layer == number; }
};

/// An edge between nodes that are there.
struct EdgeRecord {
  JsonSpan text;
  NodeKey source = 0;
  NodeKey target = 0;
  bool is_moved = false;  ///< its ends are no longer those of the text
};

/// A node that stands for a cluster.
struct ObjectNode {
  NodeKey id = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  std::string text;
};

/// An edge from a parent to a child that the file did not have.
struct NewEdge {
  NodeKey parent = 0;
  NodeKey child = 0;
};

/// Of the machine: primitives and objects are read and made independently of each other.
int countThreads();

/// What a scene graph file holds: how it is read (scene_graph_file.cpp), given objects
/// (scene_graph_objects.cpp) and written (scene_graph_output.cpp).
struct SceneGraphFile::Content {
  std::string path;
  std::optional<JsonText> json;
  JsonObject graph;     ///< the fields of the whole file
  nlohmann::json head;  ///< of these the ones that tell the layers
  GraphLayers layers;
  bool has_segments = false;
  std::vector<NodeRecord> nodes;
  std::vector<EdgeRecord> edges;
  bool has_edge_metadata = false;  ///< versions differ in what an edge has to carry
  std::vector<FilePrimitive> primitives;
  std::unordered_map<NodeKey, std::size_t> place_of;  ///< of primitives in `nodes`
  std::unordered_map<NodeKey, std::size_t> index_of;  ///< of primitives in `primitives`
  std::vector<ObjectNode> objects;                    ///< that stand for clusters
  std::vector<NewEdge> new_edges;
  FileNote left_nodes;
  FileNote no_nodes;
  FileNote left_meshes;
  FileNote left_edges;
  FileNote left_places;

  int clusteredLayer() const { return has_segments ? layers.segments : layers.objects; }

  void read(Eigen::Index embedding_size);
  JsonSpan requireList(const char* name) const;
  NodeRecord readNode(JsonSpan text) const;
  void readNodes(JsonSpan list);
  void readPrimitives(const std::vector<std::size_t>& places);
  FilePrimitive readPrimitive(const NodeRecord& node) const;
  JsonObject readAttributes(const NodeRecord& node) const;
  void readEdges(JsonSpan list);
  void leaveOtherSizes(Eigen::Index expected, bool is_tasks);
  void requirePrimitives() const;

  void replaceObjects(const std::vector<Cluster>& clusters,
                      const std::vector<std::string>& task_names);
  std::vector<NodeKey> chooseIds(const std::vector<Cluster>& clusters) const;
  void makeObjects(const std::vector<Cluster>& clusters,
                   const std::vector<std::string>& task_names);
  ObjectNode makeObject(const Cluster& cluster, NodeKey id, const std::string& task_name,
                        std::vector<BadMesh>& bad_meshes) const;
  FieldTexts mergeMembers(const Cluster& cluster, const PrimitiveUnion& whole,
                          std::vector<BadMesh>& bad_meshes) const;
  void removeReplaced();
  std::unordered_set<NodeKey> listIds() const;
  void moveEdges(const std::vector<Cluster>& clusters);
  std::map<std::size_t, NodeKey> detachSegments(const std::vector<Cluster>& clusters);
  std::pair<std::vector<NodeKey>, std::vector<Eigen::Vector3d>> listPlaces();
  void attachObjects(const std::vector<Cluster>& clusters);

  void write(std::ostream& out) const;
  void writeNodes(std::ostream& out) const;
  void writeEdges(std::ostream& out) const;

  /// What it throws names the file.
  template <typename Action>
  void namingTheFile(const Action& action) const;
};

template <typename Action>
void SceneGraphFile::Content::namingTheFile(const Action& action) const {
  try {
    action();
  } catch (const std::exception& e) {
    throw std::runtime_error("scene graph '" + path + "' " + e.what());
  }
}

}  // namespace tsg::scene_graph
