// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "file_notes.h"
#include "graph_layers.h"
#include "task_scene_graph/bottleneck/scene_graph_file.h"

namespace tsg::bottleneck {

/// What a scene graph file holds, and how it is read (scene_graph_file.cpp) and given objects
/// (scene_graph_objects.cpp).
struct SceneGraphFile::Content {
  std::string path;
  nlohmann::json graph;
  GraphLayers layers;
  bool has_segments = false;
  std::size_t num_odd_numbers = 0;
  std::vector<FilePrimitive> primitives;
  std::unordered_map<NodeKey, std::size_t> place_of;  ///< of primitives in the list of nodes
  FileNote left_nodes;
  FileNote no_nodes;
  FileNote left_meshes;
  FileNote left_edges;
  FileNote left_places;

  nlohmann::json& nodes() { return graph["nodes"]; }
  int clusteredLayer() const { return has_segments ? layers.segments : layers.objects; }
  void read(Eigen::Index embedding_size);
  void readNodes();
  void readPrimitive(std::size_t place);
  void leaveOtherSizes(Eigen::Index expected, bool is_tasks);
  void requirePrimitives() const;
  nlohmann::json makeObject(const Cluster& cluster, NodeKey id,
                            const std::vector<std::string>& task_names);
  std::vector<nlohmann::json> makeObjects(const std::vector<Cluster>& clusters,
                                          const std::vector<std::string>& task_names);
  void removeReplaced();
  void moveEdges(const std::map<NodeKey, NodeKey>& heirs,
                 const std::unordered_set<NodeKey>& former_ids);
  std::unordered_set<NodeKey> listIds() const;
  std::map<std::size_t, NodeKey> detachSegments(const std::vector<Cluster>& clusters);
  std::pair<std::vector<NodeKey>, std::vector<Eigen::Vector3d>> listPlaces();
  void attachObjects(const std::vector<nlohmann::json>& objects,
                     const std::vector<Cluster>& clusters);
  void replaceObjects(const std::vector<Cluster>& clusters,
                      const std::vector<std::string>& task_names);
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

}  // namespace tsg::bottleneck
