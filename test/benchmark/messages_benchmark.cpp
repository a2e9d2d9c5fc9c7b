// SPDX-License-Identifier: BSD-3-Clause
// ms and bytes for what is published of a graph of 50,000 primitives, 2,000 objects, 10,000 places
// and 100 regions: whole, and when as many objects and places have changed as the argument says.
#include <benchmark/benchmark.h>
#include <ros/serialization.h>
#include <visualization_msgs/MarkerArray.h>

#include <memory>
#include <string>

#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/ros/scene_graph_changes.h"
#include "task_scene_graph/ros/scene_graph_conversions.h"
#include "task_scene_graph/ros/scene_graph_markers.h"

namespace tsg::ros_interface {
namespace {

constexpr std::uint64_t kObjects = 2000;
constexpr std::uint64_t kPrimitivesPerObject = 25;
constexpr std::uint64_t kSide = 100;  ///< places stand in a square
constexpr std::uint64_t kRegions = 100;

scene_graph::SceneObject makeObject(std::uint64_t id) {
  scene_graph::SceneObject object;
  object.id = {id};
  object.task_index = static_cast<int>(id % 25);
  object.task = "task " + std::to_string(object.task_index);
  const Eigen::Vector3d corner_m(static_cast<double>(id % 50), static_cast<double>(id / 50), 0.0);
  object.box = makeAabb(corner_m, corner_m + Eigen::Vector3d::Constant(0.5));
  object.oriented_box = toOrientedBox(object.box);
  object.position_m = object.box.center();
  for (std::uint64_t i = 0; i < kPrimitivesPerObject; ++i) {
    object.primitives.push_back({(id - 1) * kPrimitivesPerObject + i + 1});
  }
  object.place = {1 + id % (kSide * kSide)};
  return object;
}

std::shared_ptr<PlaceGraph> makePlaces() {
  auto graph = std::make_shared<PlaceGraph>();
  for (std::uint64_t id = 1; id <= kSide * kSide; ++id) {
    const std::uint64_t column = (id - 1) % kSide;
    const std::uint64_t row = (id - 1) / kSide;
    graph->places.push_back(
        {{id}, {static_cast<double>(column), static_cast<double>(row), 1.0}, 0.5, {}, 1});
    if (column + 1 < kSide) graph->edges.push_back({{id}, {id + 1}, 0.5});
    if (row + 1 < kSide) graph->edges.push_back({{id}, {id + kSide}, 0.5});
    if (column + 1 < kSide && row + 1 < kSide)
      graph->edges.push_back({{id}, {id + kSide + 1}, 0.5});
  }
  return graph;
}

scene_graph::SceneGraph makeGraph() {
  scene_graph::SceneGraph graph;
  graph.world_frame = "world";
  for (int i = 0; i < 25; ++i) graph.object_tasks.push_back("task " + std::to_string(i));
  for (std::uint64_t id = 1; id <= kObjects; ++id) graph.objects.push_back(makeObject(id));
  graph.places = makePlaces();
  for (std::uint64_t id = 1; id <= kRegions; ++id) {
    scene_graph::Region region;
    region.id = {id};
    region.task = "room";
    const double x_m = static_cast<double>((id - 1) % 10) * 10.0;
    const double y_m = static_cast<double>((id - 1) / 10) * 10.0;
    region.footprint_m = {{x_m, y_m}, {x_m + 9, y_m}, {x_m + 9, y_m + 9}, {x_m, y_m + 9}};
    for (const auto& place : graph.places->places) {
      if (1 + place.id.value / kRegions == id) region.places.push_back(place.id);
    }
    graph.regions.push_back(region);
    if (id > 1) graph.region_edges.push_back({{id - 1}, {id}, 0.5, 0.1, 0.2});
  }
  return graph;
}

/// The same with `count` objects and places moved by a little, spread over all.
scene_graph::SceneGraph moveSome(const scene_graph::SceneGraph& graph, std::size_t count,
                                 double shift_m) {
  scene_graph::SceneGraph moved = graph;
  auto places = std::make_shared<PlaceGraph>(*graph.places);
  for (std::size_t i = 0; i < count; ++i) {
    places->places[(i * 997) % places->places.size()].position_m.z() += shift_m;
    scene_graph::SceneObject& object = moved.objects[(i * 97) % moved.objects.size()];
    object.position_m.z() += shift_m;
    object.box.translate(Eigen::Vector3d(0.0, 0.0, shift_m));
  }
  moved.places = places;
  return moved;
}

template <typename Message>
double countBytes(const Message& message) {
  return static_cast<double>(::ros::serialization::serializationLength(message));
}

void wholeMessage(benchmark::State& state) {
  const scene_graph::SceneGraph graph = makeGraph();
  double bytes = 0.0;
  for (auto _ : state) {
    const auto message = toMessage(graph, "world", false);
    benchmark::DoNotOptimize(::ros::serialization::serializeMessage(*message).num_bytes);
    bytes = countBytes(*message);
  }
  state.counters["bytes"] = bytes;
}
BENCHMARK(wholeMessage)->Unit(benchmark::kMillisecond);

/// A place graph as scene_graph takes it in (D = 768): beside the graph of before, with which it
/// shares what has not changed, and without one.
void placesFromAMessage(benchmark::State& state) {
  PlaceGraph graph = *makePlaces();
  for (Place& place : graph.places) place.embedding = Embedding(Embedding::Random(768));
  const auto message = toMessage(graph, "world");
  const PlaceGraph former = state.range(0) != 0 ? *fromMessage(*message) : PlaceGraph{};
  for (auto _ : state) benchmark::DoNotOptimize(fromMessage(*message, former));
  state.counters["places"] = static_cast<double>(graph.places.size());
}
BENCHMARK(placesFromAMessage)->ArgName("former")->Arg(1)->Arg(0)->Unit(benchmark::kMillisecond);

/// All that is done for the topics `scene_graph` and `scene_graph_changes`.
void messagesAfterChanges(benchmark::State& state) {
  const scene_graph::SceneGraph graph = makeGraph();
  const auto count = static_cast<std::size_t>(state.range(0));
  auto before = toMessage(graph, "world", false);
  double bytes = 0.0;
  int round = 0;
  for (auto _ : state) {
    state.PauseTiming();
    const auto moved = moveSome(graph, count, 0.001 * ++round);
    state.ResumeTiming();
    auto message = toMessage(moved, "world", false);
    benchmark::DoNotOptimize(::ros::serialization::serializeMessage(*message).num_bytes);
    const auto changes = computeChanges(*before, *message);
    benchmark::DoNotOptimize(::ros::serialization::serializeMessage(changes).num_bytes);
    bytes = countBytes(changes);
    before = message;
  }
  state.counters["bytes"] = bytes;
}
BENCHMARK(messagesAfterChanges)->Arg(0)->Arg(1)->Arg(10)->Arg(100)->Unit(benchmark::kMillisecond);

void applyingChanges(benchmark::State& state) {
  const scene_graph::SceneGraph graph = makeGraph();
  const auto before = toMessage(graph, "world", false);
  const auto after = toMessage(moveSome(graph, 10, 0.1), "world", false);
  const auto forward = computeChanges(*before, *after);
  const auto backward = computeChanges(*after, *before);
  msg::SceneGraph followed = *before;
  for (auto _ : state) {
    applyChanges(forward, followed);
    applyChanges(backward, followed);
  }
}
BENCHMARK(applyingChanges)->Unit(benchmark::kMillisecond);

void allMarkers(benchmark::State& state) {
  const scene_graph::SceneGraph graph = makeGraph();
  double bytes = 0.0;
  for (auto _ : state) {
    TaskNumbers numbers;
    SceneGraphMarkers markers(MarkerConfig{}, "world");
    const auto array = markers.update(graph, numbers);
    benchmark::DoNotOptimize(::ros::serialization::serializeMessage(array).num_bytes);
    bytes = countBytes(array);
  }
  state.counters["bytes"] = bytes;
}
BENCHMARK(allMarkers)->Unit(benchmark::kMillisecond);

void markersAfterChanges(benchmark::State& state) {
  const scene_graph::SceneGraph graph = makeGraph();
  const auto count = static_cast<std::size_t>(state.range(0));
  TaskNumbers numbers;
  SceneGraphMarkers markers(MarkerConfig{}, "world");
  markers.update(graph, numbers);
  double bytes = 0.0;
  int round = 0;
  for (auto _ : state) {
    state.PauseTiming();
    const auto moved = moveSome(graph, count, 0.001 * ++round);
    state.ResumeTiming();
    const auto array = markers.update(moved, numbers);
    benchmark::DoNotOptimize(::ros::serialization::serializeMessage(array).num_bytes);
    bytes = countBytes(array);
  }
  state.counters["bytes"] = bytes;
}
BENCHMARK(markersAfterChanges)->Arg(0)->Arg(1)->Arg(10)->Arg(100)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tsg::ros_interface

BENCHMARK_MAIN();
