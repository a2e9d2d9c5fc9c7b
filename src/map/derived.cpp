// SPDX-License-Identifier: BSD-3-Clause
// What maps are made of, and what follows from them.
#include <stdexcept>
#include <string>
#include <utility>

#include "task_scene_graph/map/map.h"
#include "task_scene_graph/mapping/marching_cubes.h"
#include "task_scene_graph/scene_graph/region_layer.h"

namespace tsg::map {
namespace {

using scene_graph::SceneGraph;

/// What the ids of a cluster name. @param find  gives a pointer, null where there is none
/// @param may_lack_embedding  as places of a region by their neighbours or by its shape do
template <typename Member, typename Id, typename Find>
std::vector<const Member*> findMembers(const char* what, const std::vector<Id>& ids,
                                       Eigen::Index embedding_size, bool may_lack_embedding,
                                       const Find& find) {
  std::vector<const Member*> members;
  members.reserve(ids.size());
  for (const Id id : ids) {
    const Member* member = find(id);
    const std::string name = "map: " + std::string(what) + " " + std::to_string(id.value);
    if (member == nullptr) throw std::invalid_argument(name + " of a cluster is not in the map");
    members.push_back(member);
    const Eigen::Index size = member->embedding.size();
    if (may_lack_embedding && size == 0) continue;
    if (embedding_size == 0) embedding_size = size;
    if (size != embedding_size) {
      throw std::invalid_argument(name + " has an embedding of " + std::to_string(size) +
                                  " numbers, expected " + std::to_string(embedding_size));
    }
  }
  return members;
}

std::vector<scene_graph::SceneObject> computeObjects(const Map& map) {
  const scene_graph::TaskList& tasks = map.objectTasks();
  const bottleneck::TaskScorer scorer(tasks.embeddings);
  std::vector<scene_graph::SceneObject> objects;
  for (const auto& cluster : map.objectClusters()) {
    if (cluster.task == 0) continue;  // published by no means
    const auto members = findMembers<ObjectPrimitive>(
        "primitive", cluster.primitives, tasks.embeddings.cols(), false,
        [&](PrimitiveId id) { return map.findPrimitive(id).get(); });
    auto object = scene_graph::describeObject(members, scorer, tasks.names);
    if (!scene_graph::isPublished(cluster.task, object, map.settings().scene_graph)) continue;
    object.id = cluster.id;
    objects.push_back(std::move(object));
  }
  scene_graph::setNearestPlaces(*map.places(), objects);
  return objects;
}

std::vector<scene_graph::Region> computeRegions(const Map& map) {
  const scene_graph::TaskList& tasks = map.placeTasks();
  const bottleneck::TaskScorer scorer(tasks.embeddings);
  std::vector<scene_graph::Region> regions;
  for (const auto& cluster : map.regionClusters()) {
    const auto members = findMembers<Place>("place", cluster.places, tasks.embeddings.cols(), true,
                                            [&](PlaceId id) { return map.findPlace(id); });
    regions.push_back(scene_graph::describeRegion(members, scorer, tasks.names,
                                                  map.settings().scene_graph.place_alpha));
    regions.back().id = cluster.id;
  }
  return regions;
}

/// As RegionLayer does; the places' features are computed anew.
void setMergeLosses(const Map& map, SceneGraph& graph) {
  if (graph.region_edges.empty()) return;
  scene_graph::RegionLayer layer(map.settings().scene_graph);
  layer.setTasks(map.placeTasks());
  layer.setPlaces(map.places());
  layer.setMergeLosses(map.regionClusters(), graph.region_edges);
}

}  // namespace

Map makeMap(scene_graph::SceneGraphBuilder& builder) {
  Map map(builder.worldFrame());
  map.setTasks(builder.objectTasks(), builder.placeTasks());
  MapSettings settings;
  settings.scene_graph = builder.config();
  map.setSettings(std::move(settings));
  map.addPrimitives(builder.primitives());
  map.setPlaces(builder.places());
  map.setClusters(builder.computeObjectClusters(), builder.computeRegionClusters());
  return map;
}

scene_graph::PrimitiveUpdate restoreBuilder(const Map& map,
                                            scene_graph::SceneGraphBuilder& builder) {
  scene_graph::checkPlaceGraph(*map.places());
  builder.reset();
  const auto update = builder.addPrimitives(map.primitives());
  builder.setPlaces(map.places());
  builder.adoptIds(map.objectClusters(), map.regionClusters());
  return update;
}

SceneGraph computeSceneGraph(const Map& map) {
  SceneGraph graph;
  graph.stamp = map.stamp();
  graph.world_frame = map.worldFrame();
  graph.config = map.settings().scene_graph;
  graph.object_tasks = map.objectTasks().names;
  graph.place_tasks = map.placeTasks().names;
  graph.primitives = map.primitives();
  graph.objects = computeObjects(map);
  graph.places = map.places();
  graph.regions = computeRegions(map);
  connectRegions(graph);
  setMergeLosses(map, graph);
  return graph;
}

Mesh computeMesh(const Map& map) {
  Mesh all;
  for (const auto& block : map.meshBlocks()) all.append(*block.mesh);
  return mapping::weldVertices(all);
}

}  // namespace tsg::map
