// SPDX-License-Identifier: BSD-3-Clause
#include "graph_layers.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace tsg::bottleneck {
namespace {

using nlohmann::json;

int findLayer(const json& graph, const char* name, int otherwise) {
  const auto names = graph.find("layer_names");
  if (names == graph.end() || names->is_null()) return otherwise;
  if (!names->is_object()) throw std::runtime_error("has 'layer_names' that are no map");
  const auto layer = names->find(name);
  if (layer == names->end()) return otherwise;
  const json& number = layer->is_object() && layer->contains("layer") ? layer->at("layer") : *layer;
  if (number.is_number_integer()) return number.get<int>();
  throw std::runtime_error("has the layer " + std::string(name) + " = " + layer->dump() +
                           ", expected its number");
}

}  // namespace

GraphLayers readLayers(const json& graph) {
  GraphLayers layers;
  layers.segments = findLayer(graph, "SEGMENTS", layers.segments);
  layers.objects = findLayer(graph, "OBJECTS", layers.objects);
  layers.places = findLayer(graph, "PLACES", layers.places);
  return layers;
}

void listObjectLayer(int layer, json& graph) {
  const bool has_keys = graph.contains("layer_keys");
  const char* name = has_keys ? "layer_keys" : "layer_ids";
  json& list = graph[name];
  if (!list.is_array() && !list.is_null()) {
    throw std::runtime_error("has '" + std::string(name) + "' that are no list");
  }
  const json key = has_keys ? json{{"layer", layer}, {"partition", 0}} : json(layer);
  if (std::find(list.begin(), list.end(), key) == list.end()) list.push_back(key);
  const auto names = graph.find("layer_names");
  if (names == graph.end() || !names->is_object() || names->contains("OBJECTS")) return;
  const bool has_numbers = !names->empty() && names->begin()->is_number();
  (*names)["OBJECTS"] = has_numbers ? json(layer) : json{{"layer", layer}, {"partition", 0}};
}

std::optional<NodeKey> readNodeId(const json& object, const char* name) {
  const auto id = object.find(name);
  if (id == object.end() || !id->is_number_unsigned()) return std::nullopt;
  return id->get<NodeKey>();
}

bool isNode(const json& entry) {
  const auto layer = entry.find("layer");
  if (!readNodeId(entry, "id") || layer == entry.end() || !layer->is_number_integer()) return false;
  const auto partition = entry.find("partition");
  return partition == entry.end() || partition->is_number_integer();
}

bool isInLayer(const json& node, int layer) {
  const auto number = node.find("layer");
  if (number == node.end() || !number->is_number_integer() || *number != layer) return false;
  const auto partition = node.find("partition");
  return (partition == node.end() || *partition == 0) && !node.contains("timestamp");
}

json makeGraphEdge(const json& graph, NodeKey parent, NodeKey child) {
  json info = {{"type", "EdgeAttributes"}, {"weight", 1.0}, {"weighted", false}};
  const json& edges = graph.at("edges");
  const auto example = std::find_if(edges.begin(), edges.end(), [](const json& edge) {
    return edge.contains("info") && edge.at("info").is_object();
  });
  // Versions differ in what else an edge has to carry.
  const bool has_metadata = example == edges.end() ? graph.contains("layer_keys")
                                                   : example->at("info").contains("metadata");
  if (has_metadata) info["metadata"] = json::object();
  return {{"source", parent}, {"target", child}, {"info", info}};
}

}  // namespace tsg::bottleneck
