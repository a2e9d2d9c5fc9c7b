// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/scene_graph.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace tsg::scene_graph {
namespace {

std::map<PlaceId, RegionId> mapPlacesToRegions(const SceneGraph& graph) {
  std::map<PlaceId, RegionId> region_of;
  for (const auto& region : graph.regions) {
    for (const PlaceId place : region.places) region_of[place] = region.id;
  }
  return region_of;
}

RegionId findRegion(const std::map<PlaceId, RegionId>& region_of, PlaceId place) {
  const auto found = region_of.find(place);
  return found == region_of.end() ? RegionId{} : found->second;
}

}  // namespace

std::vector<RegionId> computeRegionOfPlaces(const SceneGraph& graph) {
  const auto region_of = mapPlacesToRegions(graph);
  std::vector<RegionId> regions;
  for (const auto& place : graph.places->places) regions.push_back(findRegion(region_of, place.id));
  return regions;
}

std::vector<RegionId> computeRegionOfObjects(const SceneGraph& graph) {
  const auto region_of = mapPlacesToRegions(graph);
  std::vector<RegionId> regions;
  for (const auto& object : graph.objects) regions.push_back(findRegion(region_of, object.place));
  return regions;
}

std::map<PrimitiveId, std::int32_t> computeObjectOfPrimitives(const SceneGraph& graph) {
  std::map<PrimitiveId, std::int32_t> object_of;
  for (const auto& object : graph.objects) {
    for (const auto primitive : object.primitives) {
      object_of[primitive] = static_cast<std::int32_t>(object.id.value);
    }
  }
  return object_of;
}

void connectRegions(SceneGraph& graph) {
  const auto region_of = mapPlacesToRegions(graph);
  std::map<std::pair<RegionId, RegionId>, double> passages_m;
  std::map<RegionId, std::set<PlaceId>> doors;
  for (const auto& edge : graph.places->edges) {
    const RegionId a = findRegion(region_of, edge.a);
    const RegionId b = findRegion(region_of, edge.b);
    if (!a.isValid() || !b.isValid() || a == b) continue;
    doors[a].insert(edge.a);
    doors[b].insert(edge.b);
    double& passage_m = passages_m[std::minmax(a, b)];
    passage_m = std::max(passage_m, edge.clearance_m);
  }
  graph.region_edges.clear();
  for (const auto& [pair, passage_m] : passages_m) {
    graph.region_edges.push_back({pair.first, pair.second, passage_m, 0.0, 0.0});
  }
  std::map<RegionId, std::vector<ObjectId>> objects;
  for (const auto& object : graph.objects) {
    objects[findRegion(region_of, object.place)].push_back(object.id);
  }
  for (Region& region : graph.regions) {
    region.doors.assign(doors[region.id].begin(), doors[region.id].end());
    region.objects = objects[region.id];
  }
}

}  // namespace tsg::scene_graph
