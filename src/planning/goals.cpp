// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/planning/goals.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

namespace tsg::planning {
namespace {

template <typename Item, typename IdType>
const Item& findItem(const std::vector<Item>& items, IdType id, const std::string& kind) {
  for (const Item& item : items) {
    if (item.id == id) return item;
  }
  std::string there = "there is none";
  if (!items.empty()) {
    there = "there are " + std::to_string(items.size()) + ", with ids from " +
            std::to_string(items.front().id.value) + " to " + std::to_string(items.back().id.value);
  }
  throw std::invalid_argument("no " + kind + " has the id " + std::to_string(id.value) + ": " +
                              there);
}

template <typename Item>
const Item& findBest(const std::vector<Item>& items, const std::string& task,
                     const std::string& kind) {
  const Item* best = nullptr;
  std::vector<std::string> names;
  for (const Item& item : items) {
    if (item.task != task) {
      if (!item.task.empty()) names.push_back(item.task);
    } else if (best == nullptr || item.score > best->score) {
      best = &item;
    }
  }
  if (best != nullptr) return *best;
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  std::string there;
  for (const auto& name : names) there += (there.empty() ? "" : ", ") + name;
  throw std::invalid_argument("no " + kind + " is named '" + task +
                              "': " + (there.empty() ? "none has a name" : "there are: " + there));
}

}  // namespace

Goal findPlaceGoal(const PlaceGraph& places, PlaceId id) {
  return {findItem(places.places, id, "place").position_m, {}};
}

Goal findObjectGoal(const scene_graph::SceneGraph& graph, ObjectId id) {
  const scene_graph::SceneObject& object = findItem(graph.objects, id, "object");
  const bool has_box = !object.oriented_box.isEmpty();
  return {object.position_m, has_box ? object.oriented_box : toOrientedBox(object.box)};
}

Goal findRegionGoal(const scene_graph::SceneGraph& graph, RegionId id) {
  return {findItem(graph.regions, id, "region").position_m, {}};
}

ObjectId findObject(const scene_graph::SceneGraph& graph, const std::string& task) {
  return findBest(graph.objects, task, "object").id;
}

RegionId findRegion(const scene_graph::SceneGraph& graph, const std::string& task) {
  return findBest(graph.regions, task, "region").id;
}

}  // namespace tsg::planning
