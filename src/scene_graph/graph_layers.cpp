// SPDX-License-Identifier: BSD-3-Clause
#include "graph_layers.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace tsg::scene_graph {
namespace {

using nlohmann::json;

int findLayer(const json& head, const char* name, int otherwise) {
  const auto names = head.find("layer_names");
  if (names == head.end() || names->is_null()) return otherwise;
  if (!names->is_object()) throw std::runtime_error("has 'layer_names' that are no map");
  const auto layer = names->find(name);
  if (layer == names->end()) return otherwise;
  const json& number = layer->is_object() && layer->contains("layer") ? layer->at("layer") : *layer;
  if (number.is_number_integer()) return number.get<int>();
  throw std::runtime_error("has the layer " + std::string(name) + " = " + layer->dump() +
                           ", expected its number");
}

}  // namespace

GraphLayers readLayers(const json& head) {
  GraphLayers layers;
  layers.segments = findLayer(head, "SEGMENTS", layers.segments);
  layers.objects = findLayer(head, "OBJECTS", layers.objects);
  layers.places = findLayer(head, "PLACES", layers.places);
  return layers;
}

void listObjectLayer(int layer, json& head) {
  const bool has_keys = head.contains("layer_keys");
  const char* name = has_keys ? "layer_keys" : "layer_ids";
  json& list = head[name];
  if (!list.is_array() && !list.is_null()) {
    throw std::runtime_error("has '" + std::string(name) + "' that are no list");
  }
  const json key = has_keys ? json{{"layer", layer}, {"partition", 0}} : json(layer);
  if (std::find(list.begin(), list.end(), key) == list.end()) list.push_back(key);
  const auto names = head.find("layer_names");
  if (names == head.end() || !names->is_object() || names->contains("OBJECTS")) return;
  const bool has_numbers = !names->empty() && names->begin()->is_number();
  (*names)["OBJECTS"] = has_numbers ? json(layer) : json{{"layer", layer}, {"partition", 0}};
}

}  // namespace tsg::scene_graph
