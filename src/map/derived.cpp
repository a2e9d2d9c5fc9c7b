// SPDX-License-Identifier: BSD-3-Clause
// What maps are made of, and what follows from them.
#include <stdexcept>
#include <string>
#include <utility>

#include "task_scene_graph/map/map.h"
#include "task_scene_graph/mapping/marching_cubes.h"

namespace tsg::map {
namespace {

using scene_graph::SceneGraph;

/// What the ids of a cluster name. @param find  gives a pointer, null where there is none
template <typename Member, typename Id, typename Find>
std::vector<const Member*> findMembers(const char* what, const std::vector<Id>& ids,
                                       Eigen::Index embedding_size, const Find& find) {
  std::vector<const Member*> members;
  members.reserve(ids.size());
  for (const Id id : ids) {
    const Member* member = find(id);
    const std::string name = "map: " + std::string(what) + " " + std::to_string(id.value);
    if (member == nullptr) throw std::invalid_argument(name + " of a cluster is not in the map");
    const Eigen::Index expected =
        embedding_size > 0 || members.empty() ? embedding_size : members.front()->embedding.size();
    if (expected > 0 && member->embedding.size() != expected) {
      throw std::invalid_argument(name + " has an embedding of " +
                                  std::to_string(member->embedding.size()) + " numbers, expected " +
                                  std::to_string(expected));
    }
    members.push_back(member);
  }
  return members;
}

std::vector<scene_graph::SceneObject> computeObjects(const Map& map) {
  const scene_graph::TaskList& tasks = map.objectTasks();
  const bottleneck::TaskScorer scorer(tasks.embeddings);
  std::vector<scene_graph::SceneObject> objects;
  for (const auto& cluster : map.objectClusters()) {
    if (cluster.task == 0) continue;  // published by no means
    const auto members =
        findMembers<ObjectPrimitive>("primitive", cluster.primitives, tasks.embeddings.cols(),
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
    const auto members = findMembers<Place>("place", cluster.places, tasks.embeddings.cols(),
                                            [&](PlaceId id) { return map.findPlace(id); });
    regions.push_back(scene_graph::describeRegion(members, scorer, tasks.names,
                                                  map.settings().scene_graph.place_alpha));
    regions.back().id = cluster.id;
  }
  return regions;
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
  graph.region_edges = computeRegionEdges(graph);
  return graph;
}

Mesh computeMesh(const Map& map) {
  Mesh all;
  for (const auto& block : map.meshBlocks()) all.append(*block.mesh);
  return mapping::weldVertices(all);
}

}  // namespace tsg::map
