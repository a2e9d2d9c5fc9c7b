// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>

namespace tsg::scene_graph {

/// Numbers of a graph's layers: fixed ones, which 1.1 also lists by name.
struct GraphLayers {
  int segments = 1;
  int objects = 2;
  int places = 3;
};

/// @param head  the fields of a scene graph that are not its nodes and edges
/// @throws std::runtime_error saying what is wrong with `layer_names`.
GraphLayers readLayers(const nlohmann::json& head);

/// Lists the OBJECTS layer in the graph's header, in the form of its version.
/// @throws std::runtime_error saying what is wrong with `layer_keys` or `layer_ids`.
void listObjectLayer(int layer, nlohmann::json& head);

}  // namespace tsg::scene_graph
