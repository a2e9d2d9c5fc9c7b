// SPDX-License-Identifier: BSD-3-Clause
// ms per snapshot for 100 to 3000 object primitives and a third as many places, D = 768, 25 tasks,
// after the changes that happen while mapping and while a user turns the knobs.
#include <benchmark/benchmark.h>

#include <filesystem>
#include <random>

#include "support.h"
#include "task_scene_graph/scene_graph/builder.h"
#include "task_scene_graph/scene_graph/files.h"

namespace tsg::scene_graph {
namespace {

constexpr int kEmbeddingSize = 768;
constexpr int kTasks = 25;

class World {
 public:
  explicit World(int num_primitives) {
    for (int t = 0; t < kTasks; ++t) tasks.names.push_back("task " + std::to_string(t));
    tasks.embeddings =
        EmbeddingMatrix::NullaryExpr(kTasks, kEmbeddingSize, [&] { return normal_(random_); });
    side_m_ = 2.0 * std::sqrt(num_primitives / 3.0);
    for (int i = 1; i <= num_primitives; ++i) primitives.push_back(makePrimitive(i));
    for (int i = 1; i <= num_primitives / 3; ++i) addPlace(i);
  }

  ObjectPrimitivePtr makePrimitive(int id) {
    auto primitive = std::make_shared<ObjectPrimitive>();
    primitive->id = {static_cast<std::uint64_t>(id)};
    const Eigen::Vector3d corner_m(draw(0, side_m_), draw(0, side_m_), draw(0, 1));
    primitive->box = makeAabb(corner_m, corner_m + Eigen::Vector3d::Constant(draw(0.3, 0.8)));
    primitive->embedding = makeEmbedding();
    return primitive;
  }

  Embedding makeEmbedding() {
    const auto task = std::uniform_int_distribution<Eigen::Index>(0, kTasks - 1)(random_);
    const auto weight = static_cast<float>(draw(0, 0.6));
    return weight * tasks.embeddings.row(task).transpose() +
           Embedding::NullaryExpr(kEmbeddingSize, [&] { return normal_(random_); });
  }

  /// The same graph in new memory, with `count` places seen once more.
  PlaceGraphPtr seePlacesAgain(int count) {
    for (int i = 0; i < count && !places.places.empty(); ++i) {
      const auto last = places.places.size() - 1;
      places.places[static_cast<std::size_t>(draw(0, static_cast<double>(last)))].embedding =
          makeEmbedding();
    }
    return std::make_shared<PlaceGraph>(places);
  }

  SceneGraphBuilder makeBuilder() {
    SceneGraphBuilder builder(SceneGraphConfig{});
    builder.setObjectTasks(tasks);
    builder.setPlaceTasks(tasks);
    builder.addPrimitives(primitives);
    builder.setPlaces(seePlacesAgain(0));
    builder.snapshot();
    return builder;
  }

  TaskList tasks;
  std::vector<ObjectPrimitivePtr> primitives;
  PlaceGraph places;

 private:
  void addPlace(int id) {
    const PlaceId place{static_cast<std::uint64_t>(id)};
    places.places.push_back(
        {place, {draw(0, side_m_), draw(0, side_m_), 1}, draw(0.4, 2), makeEmbedding(), 1});
    if (id > 1) places.edges.push_back({{place.value - 1}, place, 0.5});
  }
  double draw(double min, double max) {
    return std::uniform_real_distribution<double>(min, max)(random_);
  }

  std::mt19937 random_{1};
  std::normal_distribution<float> normal_;
  double side_m_ = 0.0;
};

void snapshotAfterFiveNewPrimitives(benchmark::State& state) {
  const int count = static_cast<int>(state.range(0));
  World world(count);
  SceneGraphBuilder builder = world.makeBuilder();
  int id = count;
  for (auto _ : state) {
    state.PauseTiming();
    std::vector<ObjectPrimitivePtr> fresh;
    for (int i = 0; i < 5; ++i) fresh.push_back(world.makePrimitive(++id));
    state.ResumeTiming();
    builder.addPrimitives(fresh);
    benchmark::DoNotOptimize(builder.snapshot());
  }
}
BENCHMARK(snapshotAfterFiveNewPrimitives)
    ->Arg(100)
    ->Arg(1000)
    ->Arg(3000)
    ->Iterations(20)
    ->Unit(benchmark::kMillisecond);

void snapshotAfterTenPlacesSeenAgain(benchmark::State& state) {
  World world(static_cast<int>(state.range(0)));
  SceneGraphBuilder builder = world.makeBuilder();
  for (auto _ : state) {
    state.PauseTiming();
    const PlaceGraphPtr places = world.seePlacesAgain(10);
    state.ResumeTiming();
    builder.setPlaces(places);
    benchmark::DoNotOptimize(builder.snapshot());
  }
}
BENCHMARK(snapshotAfterTenPlacesSeenAgain)
    ->Arg(100)
    ->Arg(1000)
    ->Arg(3000)
    ->Unit(benchmark::kMillisecond);

void comparePlacesThatDidNotChange(benchmark::State& state) {
  World world(static_cast<int>(state.range(0)));
  SceneGraphBuilder builder = world.makeBuilder();
  const PlaceGraphPtr copies[] = {world.seePlacesAgain(0), world.seePlacesAgain(0)};
  std::size_t turn = 0;
  for (auto _ : state) builder.setPlaces(copies[++turn % 2]);
}
BENCHMARK(comparePlacesThatDidNotChange)->Arg(1000)->Arg(3000)->Unit(benchmark::kMillisecond);

void snapshotAfterChangeOfDelta(benchmark::State& state) {
  SceneGraphBuilder builder = World(static_cast<int>(state.range(0))).makeBuilder();
  SceneGraphConfig config;
  for (auto _ : state) {
    config.object_delta = config.object_delta == 1e-5 ? 1e-4 : 1e-5;
    builder.setConfig(config);
    benchmark::DoNotOptimize(builder.snapshot());
  }
}
BENCHMARK(snapshotAfterChangeOfDelta)
    ->Arg(100)
    ->Arg(1000)
    ->Arg(3000)
    ->Unit(benchmark::kMillisecond);

void snapshotAfterChangeOfAlpha(benchmark::State& state) {
  SceneGraphBuilder builder = World(static_cast<int>(state.range(0))).makeBuilder();
  SceneGraphConfig config;
  for (auto _ : state) {
    config.object_alpha = config.object_alpha == 0.23 ? 0.25 : 0.23;
    builder.setConfig(config);
    benchmark::DoNotOptimize(builder.snapshot());
  }
}
BENCHMARK(snapshotAfterChangeOfAlpha)
    ->Arg(100)
    ->Arg(1000)
    ->Arg(3000)
    ->Unit(benchmark::kMillisecond);

void writeSparkDsgFile(benchmark::State& state) {
  World world(static_cast<int>(state.range(0)));
  const SceneGraphPtr graph = world.makeBuilder().snapshot();
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "graph.json").string();
  for (auto _ : state) writeSparkDsg(path, *graph);
  state.counters["MB"] = static_cast<double>(std::filesystem::file_size(path)) * 1e-6;
}
BENCHMARK(writeSparkDsgFile)->Arg(1000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tsg::scene_graph

BENCHMARK_MAIN();
