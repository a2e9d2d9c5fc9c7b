// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/scene_graph_changes.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "task_scene_graph/ros/image_conversions.h"

namespace tsg::ros_interface {
namespace {

using EdgeKey = std::pair<std::uint64_t, std::uint64_t>;

std::uint64_t keyOf(const msg::SceneObject& object) { return object.id; }
std::uint64_t keyOf(const msg::Place& place) { return place.id; }
std::uint64_t keyOf(const msg::Region& region) { return region.id; }
EdgeKey keyOf(const msg::PlaceEdge& edge) { return {edge.a, edge.b}; }
EdgeKey keyOf(const msg::RegionEdge& edge) { return {edge.a, edge.b}; }

std::string toText(std::uint64_t id) { return std::to_string(id); }
std::string toText(const EdgeKey& edge) {
  return std::to_string(edge.first) + "-" + std::to_string(edge.second);
}

void addKey(std::uint64_t id, std::vector<std::uint64_t>& keys) { keys.push_back(id); }
void addKey(const EdgeKey& edge, std::vector<std::uint64_t>& keys) {
  keys.push_back(edge.first);
  keys.push_back(edge.second);
}

/// Both lists ascend by key.
template <typename Item>
void compare(const std::vector<Item>& before, const std::vector<Item>& after,
             std::vector<Item>& changed, std::vector<std::uint64_t>& removed) {
  auto old = before.begin();
  for (const Item& item : after) {
    for (; old != before.end() && keyOf(*old) < keyOf(item); ++old) addKey(keyOf(*old), removed);
    const bool is_known = old != before.end() && keyOf(*old) == keyOf(item);
    if (!is_known || !(*old == item)) changed.push_back(item);
    if (is_known) ++old;
  }
  for (; old != before.end(); ++old) addKey(keyOf(*old), removed);
}

std::vector<std::uint64_t> readKeys(const std::vector<std::uint64_t>& values, std::uint64_t) {
  return values;
}
std::vector<EdgeKey> readKeys(const std::vector<std::uint64_t>& values, const EdgeKey&) {
  if (values.size() % 2 != 0) throw InputError("edges to be removed have an odd number of ends");
  std::vector<EdgeKey> keys;
  for (std::size_t i = 0; i < values.size(); i += 2) keys.emplace_back(values[i], values[i + 1]);
  return keys;
}

template <typename Keys>
void checkAscending(const Keys& keys, const std::string& what) {
  const auto out_of_order = std::adjacent_find(
      keys.begin(), keys.end(), [](const auto& a, const auto& b) { return !(a < b); });
  if (out_of_order == keys.end()) return;
  throw InputError(what + " " + toText(*out_of_order) + " is not before the next, expected them " +
                   "ascending and each once");
}

/// The list with its changes.
template <typename Item>
std::vector<Item> merge(const std::vector<Item>& before, const std::vector<Item>& changed,
                        const std::vector<std::uint64_t>& removed_values, const std::string& what) {
  using Key = decltype(keyOf(std::declval<Item>()));
  const std::vector<Key> removed = readKeys(removed_values, Key{});
  std::vector<Key> changed_keys;
  for (const Item& item : changed) changed_keys.push_back(keyOf(item));
  checkAscending(removed, what);
  checkAscending(changed_keys, what);
  std::vector<Item> after;
  after.reserve(before.size() + changed.size());
  auto next = changed.begin();
  auto gone = removed.begin();
  for (const Item& item : before) {
    const Key key = keyOf(item);
    while (next != changed.end() && keyOf(*next) < key) after.push_back(*next++);
    if (gone != removed.end() && *gone == key) {
      ++gone;
    } else {
      const bool is_changed = next != changed.end() && keyOf(*next) == key;
      after.push_back(is_changed ? *next++ : item);
    }
  }
  after.insert(after.end(), next, changed.end());
  if (gone == removed.end()) return after;
  throw InputError(what + " " + toText(*gone) + " is removed, but is not there");
}

}  // namespace

msg::SceneGraphChanges computeChanges(const msg::SceneGraph& before, const msg::SceneGraph& after) {
  msg::SceneGraphChanges changes;
  changes.header = after.header;
  if (before.object_tasks != after.object_tasks || before.place_tasks != after.place_tasks) {
    changes.has_tasks = 1;
    changes.object_tasks = after.object_tasks;
    changes.place_tasks = after.place_tasks;
  }
  compare(before.objects, after.objects, changes.objects, changes.removed_objects);
  compare(before.places, after.places, changes.places, changes.removed_places);
  compare(before.place_edges, after.place_edges, changes.place_edges, changes.removed_place_edges);
  compare(before.regions, after.regions, changes.regions, changes.removed_regions);
  compare(before.region_edges, after.region_edges, changes.region_edges,
          changes.removed_region_edges);
  return changes;
}

msg::SceneGraphChanges toWholeGraph(const msg::SceneGraph& graph, std::uint64_t sequence) {
  msg::SceneGraphChanges changes = computeChanges({}, graph);
  changes.sequence = sequence;
  changes.is_whole = 1;
  changes.has_tasks = 1;
  changes.object_tasks = graph.object_tasks;
  changes.place_tasks = graph.place_tasks;
  return changes;
}

void applyChanges(const msg::SceneGraphChanges& changes, msg::SceneGraph& graph) {
  msg::SceneGraph after;
  after.header = changes.header;
  after.objects = merge(graph.objects, changes.objects, changes.removed_objects, "object");
  after.places = merge(graph.places, changes.places, changes.removed_places, "place");
  after.place_edges =
      merge(graph.place_edges, changes.place_edges, changes.removed_place_edges, "place edge");
  after.regions = merge(graph.regions, changes.regions, changes.removed_regions, "region");
  after.region_edges =
      merge(graph.region_edges, changes.region_edges, changes.removed_region_edges, "region edge");
  after.object_tasks = changes.has_tasks != 0 ? changes.object_tasks : graph.object_tasks;
  after.place_tasks = changes.has_tasks != 0 ? changes.place_tasks : graph.place_tasks;
  graph = std::move(after);
}

SceneGraphReader::Status SceneGraphReader::apply(const msg::SceneGraphChanges& changes) {
  if (changes.is_whole == 0) {
    if (!has_graph_) return Status::kWaiting;
    if (changes.sequence <= sequence_) return Status::kKnown;
    if (changes.sequence != sequence_ + 1) {
      has_graph_ = false;
      return Status::kLost;
    }
  }
  try {
    msg::SceneGraph graph = changes.is_whole != 0 ? msg::SceneGraph() : std::move(graph_);
    has_graph_ = false;
    applyChanges(changes, graph);
    graph_ = std::move(graph);
  } catch (const InputError&) {
    return Status::kLost;
  }
  has_graph_ = true;
  sequence_ = changes.sequence;
  return Status::kApplied;
}

}  // namespace tsg::ros_interface
