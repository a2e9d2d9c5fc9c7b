// SPDX-License-Identifier: BSD-3-Clause
// From a slider or a change of tasks to what is published: ms until the graph message is serialized
// (`message_ms`), and until changes and markers are, too (the time of the benchmark). The map:
// 50,000 object primitives in 2,000 heaps of overlapping boxes, 10,000 places in 100 rooms, D =
// 768, 25 tasks; a heap is one thing, and serves one task or none. Also the memory of such a map.
#include <benchmark/benchmark.h>
#include <ros/serialization.h>
#include <visualization_msgs/MarkerArray.h>

#include <chrono>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "peak_memory.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/ros/scene_graph_changes.h"
#include "task_scene_graph/ros/scene_graph_conversions.h"
#include "task_scene_graph/ros/scene_graph_markers.h"
#include "task_scene_graph/scene_graph/builder.h"

namespace tsg::ros_interface {
namespace {

using scene_graph::SceneGraphBuilder;
using scene_graph::SceneGraphConfig;
using scene_graph::TaskList;

constexpr int kSize = 768;
constexpr int kTasks = 25;
constexpr std::uint64_t kHeaps = 2000;
constexpr std::uint64_t kPrimitivesPerHeap = 25;
constexpr std::uint64_t kPrimitives = kHeaps * kPrimitivesPerHeap;
constexpr std::uint64_t kSide = 100;  ///< places stand in a square, in rooms of 10 x 10
constexpr double kSpacing_m = 2.0;    ///< of heaps and of places

class World {
 public:
  World() {
    tasks.embeddings = EmbeddingMatrix::NullaryExpr(kTasks, kSize, [&] { return draw(); });
    tasks.embeddings.rowwise().normalize();
    for (int t = 0; t < kTasks; ++t) tasks.names.push_back("task " + std::to_string(t));
    places = makePlaces();
  }

  /// A heap: what one thing looks like from 25 sides.
  std::vector<ObjectPrimitivePtr> makeHeap(std::uint64_t heap) {
    const Eigen::Vector3d corner_m(kSpacing_m * static_cast<double>(heap % 50),
                                   kSpacing_m * static_cast<double>(heap / 50), 0.0);
    const Embedding thing = makeEmbedding(heap % kTasks, heap % 4 == 0 ? 0.0F : 0.5F);
    std::vector<ObjectPrimitivePtr> primitives;
    for (std::uint64_t i = 1; i <= kPrimitivesPerHeap; ++i) {
      auto primitive = std::make_shared<ObjectPrimitive>();
      primitive->id = {heap * kPrimitivesPerHeap + i};
      const Eigen::Vector3d shift_m(0.02 * static_cast<double>(i % 5),
                                    0.02 * static_cast<double>(i / 5), 0.0);
      primitive->box =
          makeAabb(corner_m + shift_m, corner_m + shift_m + Eigen::Vector3d::Constant(0.5));
      primitive->oriented_box = toOrientedBox(primitive->box);
      primitive->embedding = thing + 0.3F * makeNoise();
      primitives.push_back(std::move(primitive));
    }
    return primitives;
  }

  TaskList tasks;
  PlaceGraphPtr places;

 private:
  float draw() { return normal_(random_); }
  Embedding makeNoise() {
    return Embedding::NullaryExpr(kSize, [&] { return draw(); }).normalized();
  }
  Embedding makeEmbedding(std::uint64_t task, float weight) {
    return weight * tasks.embeddings.row(static_cast<Eigen::Index>(task)).transpose() + makeNoise();
  }
  PlaceGraphPtr makePlaces() {
    auto graph = std::make_shared<PlaceGraph>();
    for (std::uint64_t i = 0; i < kSide * kSide; ++i) {
      const std::uint64_t column = i % kSide;
      const std::uint64_t row = i / kSide;
      const std::uint64_t room = 10 * (row / 10) + column / 10;
      graph->places.push_back(
          {{i + 1},
           {kSpacing_m * static_cast<double>(column), kSpacing_m * static_cast<double>(row), 1.0},
           0.5,
           makeEmbedding(room % kTasks, 0.6F),
           1});
      if (column + 1 < kSide) graph->edges.push_back({{i + 1}, {i + 2}, 0.5});
      if (row + 1 < kSide) graph->edges.push_back({{i + 1}, {i + 1 + kSide}, 0.5});
    }
    return graph;
  }

  std::mt19937 random_{1};
  std::normal_distribution<float> normal_;
};

/// Heap in use, since construction.
class Memory {
 public:
  Memory() : before_MB_(read_MB()) {}
  double perPrimitive() const { return (read_MB() - before_MB_) * 1024.0 * 1024.0 / kPrimitives; }

 private:
  static double read_MB() {
    malloc_trim(0);
    return test::readStatus_MB("VmRSS");
  }
  double before_MB_;
};

/// What scene_graph has before it, and what it keeps to tell what changed.
class Stage {
 public:
  Stage() : builder_(SceneGraphConfig{}), markers_(MarkerConfig{}, "world") {
    World world;
    tasks_ = world.tasks;
    builder_.setObjectTasks(tasks_);
    builder_.setPlaceTasks(tasks_);
    const Memory memory;
    std::vector<ObjectPrimitivePtr> primitives;
    for (std::uint64_t heap = 0; heap < kHeaps; ++heap) {
      for (auto& primitive : world.makeHeap(heap)) primitives.push_back(std::move(primitive));
    }
    own_bytes_ = memory.perPrimitive() - kSize * sizeof(float);
    builder_.addPrimitives(primitives);
    builder_.snapshot();
    primitives = {};
    all_bytes_ = memory.perPrimitive() - kSize * sizeof(float);
    builder_.setPlaces(world.places);
    publish(nullptr);
  }

  SceneGraphBuilder& builder() { return builder_; }
  const TaskList& tasks() const { return tasks_; }
  /// Of one primitive without a mesh, but for its embedding.
  double ownBytes() const { return own_bytes_; }
  /// ... with what clustering and graph keep of it.
  double allBytes() const { return all_bytes_; }

  using Time = std::chrono::steady_clock::time_point;

  /// @param start  when the change came
  void publish(benchmark::State* state, Time start = std::chrono::steady_clock::now()) {
    const auto graph = builder_.snapshot();
    auto message = toMessage(*graph, "world", false);
    benchmark::DoNotOptimize(::ros::serialization::serializeMessage(*message).num_bytes);
    const std::chrono::duration<double, std::milli> spent =
        std::chrono::steady_clock::now() - start;
    message_ms_ += spent.count();
    const auto changes = computeChanges(message_ ? *message_ : msg::SceneGraph(), *message);
    benchmark::DoNotOptimize(::ros::serialization::serializeMessage(changes).num_bytes);
    const auto markers = markers_.update(*graph, numbers_);
    benchmark::DoNotOptimize(::ros::serialization::serializeMessage(markers).num_bytes);
    message_ = message;
    if (state == nullptr) return;
    state->counters["objects"] = static_cast<double>(graph->objects.size());
    state->counters["regions"] = static_cast<double>(graph->regions.size());
    state->counters["bytes"] =
        static_cast<double>(::ros::serialization::serializationLength(changes));
  }
  double takeMessage_ms() { return std::exchange(message_ms_, 0.0); }

 private:
  SceneGraphBuilder builder_;
  SceneGraphMarkers markers_;
  TaskNumbers numbers_;
  TaskList tasks_;
  msg::SceneGraphPtr message_;
  double own_bytes_ = 0.0;
  double all_bytes_ = 0.0;
  double message_ms_ = 0.0;
};

/// One for all: it takes seconds and hundreds of megabytes to make.
Stage& stage() {
  static Stage stage;
  return stage;
}

/// @param change  there (true) and back
template <typename Change>
void runChanges(benchmark::State& state, const Change& change) {
  Stage& chain = stage();
  bool is_there = false;
  for (int i = 0; i < 2; ++i) {  // what was never asked for takes its tapes the first time
    change(chain, is_there = !is_there);
    chain.publish(nullptr);
  }
  chain.takeMessage_ms();
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    change(chain, is_there = !is_there);
    chain.publish(&state, start);
  }
  state.counters["message_ms"] =
      benchmark::Counter(chain.takeMessage_ms(), benchmark::Counter::kAvgIterations);
  change(chain, false);
  chain.publish(nullptr);
}

template <typename Tune>
void tune(benchmark::State& state, const Tune& set) {
  runChanges(state, [&](Stage& chain, bool is_there) {
    SceneGraphConfig config;
    if (is_there) set(config);
    chain.builder().setConfig(config);
  });
}

void changeOfDelta(benchmark::State& state) {
  tune(state, [](SceneGraphConfig& config) { config.object_delta = 1e-7; });
}
void changeOfAlpha(benchmark::State& state) {
  tune(state, [](SceneGraphConfig& config) { config.object_alpha = 0.26; });
}
void changeOfPlaceDelta(benchmark::State& state) {
  tune(state, [](SceneGraphConfig& config) { config.place_delta_bits = 0.1; });
}
void changeOfPlaceAlpha(benchmark::State& state) {
  tune(state, [](SceneGraphConfig& config) { config.place_alpha = 0.26; });
}

void changeOfTasks(benchmark::State& state) {
  const TaskList all = stage().tasks();
  TaskList fewer = all;
  fewer.names.resize(20);
  fewer.embeddings.conservativeResize(20, Eigen::NoChange);
  runChanges(state, [&](Stage& chain, bool is_there) {
    chain.builder().setObjectTasks(is_there ? fewer : all);
  });
}

/// Not timed: says what a primitive takes.
void memoryOfAPrimitive(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(stage().allBytes());
  state.counters["own_bytes"] = stage().ownBytes();
  state.counters["all_bytes"] = stage().allBytes();
}

BENCHMARK(changeOfDelta)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
BENCHMARK(changeOfAlpha)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
BENCHMARK(changeOfTasks)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
BENCHMARK(changeOfPlaceDelta)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK(changeOfPlaceAlpha)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK(memoryOfAPrimitive)->Iterations(1);

}  // namespace
}  // namespace tsg::ros_interface

BENCHMARK_MAIN();
