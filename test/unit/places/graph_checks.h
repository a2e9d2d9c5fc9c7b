// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <set>
#include <vector>

#include "task_scene_graph/core/primitives.h"

namespace tsg::places::test {

/// Connected parts of a place graph, as sets of ids.
inline std::vector<std::set<PlaceId>> findParts(const PlaceGraph& graph) {
  std::map<PlaceId, std::set<PlaceId>> neighbours;
  for (const Place& place : graph.places) neighbours[place.id];
  for (const PlaceEdge& edge : graph.edges) {
    neighbours[edge.a].insert(edge.b);
    neighbours[edge.b].insert(edge.a);
  }
  std::vector<std::set<PlaceId>> parts;
  std::set<PlaceId> seen;
  for (const auto& [id, ignored] : neighbours) {
    if (seen.count(id) > 0) continue;
    std::set<PlaceId> part;
    std::vector<PlaceId> open{id};
    while (!open.empty()) {
      const PlaceId at = open.back();
      open.pop_back();
      if (!part.insert(at).second) continue;
      for (const PlaceId next : neighbours[at]) open.push_back(next);
    }
    seen.insert(part.begin(), part.end());
    parts.push_back(part);
  }
  return parts;
}

inline const Place& findPlace(const PlaceGraph& graph, PlaceId id) {
  for (const Place& place : graph.places) {
    if (place.id == id) return place;
  }
  throw std::runtime_error("the graph has an edge to a place that it does not have");
}

}  // namespace tsg::places::test
