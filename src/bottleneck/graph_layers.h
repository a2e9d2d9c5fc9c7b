// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "task_scene_graph/bottleneck/primitive_graph.h"

namespace tsg::bottleneck {

/// Numbers of a graph's layers: fixed ones, which 1.1 also lists by name.
struct GraphLayers {
  int segments = 1;
  int objects = 2;
  int places = 3;
};

/// @throws std::runtime_error saying what is wrong with `layer_names`.
GraphLayers readLayers(const nlohmann::json& graph);

/// Lists the OBJECTS layer in the graph's header, in the form of its version.
/// @throws std::runtime_error saying what is wrong with `layer_keys` or `layer_ids`.
void listObjectLayer(int layer, nlohmann::json& graph);

/// A node id, or nothing if it is none.
std::optional<NodeKey> readNodeId(const nlohmann::json& object, const char* name);

/// Whether an entry of `nodes` has what tells its layer: id, layer, and no or a whole partition.
bool isNode(const nlohmann::json& entry);

/// Whether a node lies in a static layer. Nodes of dynamic layers share its number: 1.0 gives them
/// a timestamp, 1.1 a partition. False for what is no node.
bool isInLayer(const nlohmann::json& node, int layer);

/// An edge from parent to child as the graph's version writes them.
nlohmann::json makeGraphEdge(const nlohmann::json& graph, NodeKey parent, NodeKey child);

}  // namespace tsg::bottleneck
