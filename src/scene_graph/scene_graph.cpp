// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/scene_graph.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "place_index.h"

namespace tsg::scene_graph {
namespace {

/// Which region each place of a graph is in.
class RegionOfPlaces {
 public:
  explicit RegionOfPlaces(const SceneGraph& graph)
      : index_(*graph.places), regions_(graph.places->places.size()) {
    for (const auto& region : graph.regions) {
      for (const PlaceId place : region.places) {
        const std::size_t i = index_.find(place);
        if (i != PlaceIndex::kNone) regions_[i] = region.id;
      }
    }
  }

  /// Not valid if the place is in none, or not there.
  RegionId find(PlaceId place) const {
    const std::size_t i = index_.find(place);
    return i == PlaceIndex::kNone ? RegionId{} : regions_[i];
  }
  const std::vector<RegionId>& regions() const { return regions_; }  ///< by place

 private:
  PlaceIndex index_;
  std::vector<RegionId> regions_;
};

}  // namespace

std::vector<RegionId> computeRegionOfPlaces(const SceneGraph& graph) {
  return RegionOfPlaces(graph).regions();
}

std::vector<RegionId> computeRegionOfObjects(const SceneGraph& graph) {
  const RegionOfPlaces region_of(graph);
  std::vector<RegionId> regions;
  for (const auto& object : graph.objects) regions.push_back(region_of.find(object.place));
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
  const RegionOfPlaces region_of(graph);
  std::map<std::pair<RegionId, RegionId>, double> passages_m;
  std::map<RegionId, std::set<PlaceId>> doors;
  for (const auto& edge : graph.places->edges) {
    const RegionId a = region_of.find(edge.a);
    const RegionId b = region_of.find(edge.b);
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
    objects[region_of.find(object.place)].push_back(object.id);
  }
  for (Region& region : graph.regions) {
    region.doors.assign(doors[region.id].begin(), doors[region.id].end());
    region.objects = objects[region.id];
  }
}

}  // namespace tsg::scene_graph
