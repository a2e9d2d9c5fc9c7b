// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/builder.h"

#include <algorithm>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/scene_graph/clusters.h"

namespace tsg::scene_graph {
namespace {

SceneGraphConfig validated(const SceneGraphConfig& config) {
  config::validate(config, "scene graph configuration");
  return config;
}

bool isSame(const SceneGraphConfig& a, const SceneGraphConfig& b) {
  return YAML::Dump(config::toYaml(a)) == YAML::Dump(config::toYaml(b));
}

}  // namespace

SceneGraphBuilder::SceneGraphBuilder(const SceneGraphConfig& config, std::string world_frame)
    : config_(validated(config)),
      world_frame_(std::move(world_frame)),
      objects_(std::make_unique<ObjectLayer>(config)),
      regions_(std::make_unique<RegionLayer>(config)) {}

void SceneGraphBuilder::setObjectTasks(const TaskList& tasks) {
  if (tasks == objects_->tasks()) return;
  objects_->setTasks(tasks);
  snapshot_.reset();
}

void SceneGraphBuilder::setPlaceTasks(const TaskList& tasks) {
  if (tasks == regions_->tasks()) return;
  regions_->setTasks(tasks);
  snapshot_.reset();
}

void SceneGraphBuilder::setConfig(const SceneGraphConfig& config) {
  if (isSame(config, config_)) return;
  config_ = validated(config);
  objects_->setConfig(config);
  regions_->setConfig(config);
  snapshot_.reset();
}

PrimitiveUpdate SceneGraphBuilder::addPrimitives(const std::vector<ObjectPrimitivePtr>& primitives,
                                                 Repeated repeated) {
  const PrimitiveUpdate update = objects_->add(primitives, repeated);
  if (update.counters.clustered + update.counters.without_embedding > 0) snapshot_.reset();
  return update;
}

std::size_t SceneGraphBuilder::erasePrimitives(const std::vector<PrimitiveId>& ids) {
  const std::size_t num_erased = objects_->erase(ids);
  if (num_erased > 0) snapshot_.reset();
  return num_erased;
}

void SceneGraphBuilder::reset() {
  const TaskList object_tasks = objects_->tasks();
  const TaskList place_tasks = regions_->tasks();
  objects_ = std::make_unique<ObjectLayer>(config_);
  regions_ = std::make_unique<RegionLayer>(config_);
  snapshot_.reset();
  setObjectTasks(object_tasks);
  setPlaceTasks(place_tasks);
}

PlaceUpdate SceneGraphBuilder::setPlaces(const PlaceGraphPtr& places) {
  if (places == regions_->places()) return {};
  const PlaceUpdate update = regions_->setPlaces(places);
  snapshot_.reset();
  return update;
}

void SceneGraphBuilder::adoptIds(const std::vector<ObjectCluster>& objects,
                                 const std::vector<RegionCluster>& regions) {
  objects_->adoptIds(objects);
  regions_->adoptIds(regions);
  snapshot_.reset();
}

SceneGraphPtr SceneGraphBuilder::snapshot() {
  if (snapshot_) return snapshot_;
  auto graph = std::make_shared<SceneGraph>();
  graph->config = config_;
  graph->world_frame = world_frame_;
  graph->object_tasks = objects_->tasks().names;
  graph->place_tasks = regions_->tasks().names;
  graph->primitives = objects_->primitives();
  graph->objects = objects_->computeObjects();
  graph->places = regions_->places();
  graph->regions = regions_->computeRegions();
  graph->stamp = std::max(objects_->newest(), graph->places->stamp);
  setNearestPlaces(*graph->places, graph->objects);
  connectRegions(*graph);
  regions_->setMergeLosses(regions_->computeClusters(), graph->region_edges);
  snapshot_ = graph;
  return snapshot_;
}

}  // namespace tsg::scene_graph
