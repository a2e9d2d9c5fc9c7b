// SPDX-License-Identifier: BSD-3-Clause
// ms for regions of 1,000 to 10,000 places (rooms of 100 on a grid, doors between them, D = 768, 25
// place tasks) after ten of them were seen again; beside it a batch run over all.
#include <benchmark/benchmark.h>

#include <cmath>
#include <random>

#include "task_scene_graph/scene_graph/builder.h"
#include "task_scene_graph/scene_graph/geometric_rooms.h"
#include "task_scene_graph/scene_graph/region_layer.h"

namespace tsg::scene_graph {
namespace {

constexpr int kEmbeddingSize = 768;
constexpr int kTasks = 25;
constexpr std::uint64_t kRoomSide = 10;  // places

/// Rows of rooms, all alike: 10 x 10 places 0.5 m apart, a door in the middle of each wall.
class Building {
 public:
  explicit Building(std::uint64_t num_places) {
    for (int t = 0; t < kTasks; ++t) tasks.names.push_back("task " + std::to_string(t));
    tasks.embeddings =
        EmbeddingMatrix::NullaryExpr(kTasks, kEmbeddingSize, [&] { return normal_(random_); });
    side_ = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(num_places)));
    for (std::uint64_t y = 0; y < side_; ++y) {
      for (std::uint64_t x = 0; x < side_; ++x) addPlace(x, y);
    }
  }

  /// The same graph once more, with `count` places of one room seen again: the others share their
  /// embeddings, as those of a PlaceExtractor do.
  PlaceGraphPtr seeAgain(std::uint64_t count) {
    const std::uint64_t corner = draw(side_ / kRoomSide) * kRoomSide;
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::uint64_t x = corner + draw(kRoomSide);
      const std::uint64_t y = corner + draw(kRoomSide);
      places_.places[y * side_ + x].embedding = makeEmbedding(x, y);
    }
    return std::make_shared<PlaceGraph>(places_);
  }

  /// The same, with embeddings of its own.
  PlaceGraphPtr readAnew() {
    auto graph = std::make_shared<PlaceGraph>(places_);
    for (Place& place : graph->places) place.embedding = Embedding(*place.embedding);
    return graph;
  }

  TaskList tasks;

 private:
  std::uint64_t draw(std::uint64_t count) {
    return std::uniform_int_distribution<std::uint64_t>(0, count - 1)(random_);
  }
  PlaceId idAt(std::uint64_t x, std::uint64_t y) const { return {y * side_ + x + 1}; }

  Embedding makeEmbedding(std::uint64_t x, std::uint64_t y) {
    const std::uint64_t room = x / kRoomSide + 7 * (y / kRoomSide);
    const auto task = static_cast<Eigen::Index>(room % kTasks);
    return 0.5F * tasks.embeddings.row(task).transpose() +
           Embedding::NullaryExpr(kEmbeddingSize, [&] { return normal_(random_); });
  }

  void addPlace(std::uint64_t x, std::uint64_t y) {
    places_.places.push_back({idAt(x, y),
                              {0.5 * static_cast<double>(x), 0.5 * static_cast<double>(y), 0.5},
                              0.8,
                              makeEmbedding(x, y),
                              1});
    const auto join = [&](std::uint64_t next, std::uint64_t along, PlaceId to) {
      const bool is_wall = next % kRoomSide == 0;
      if (next >= side_ || (is_wall && along % kRoomSide != kRoomSide / 2)) return;
      places_.edges.push_back({idAt(x, y), to, is_wall ? 0.4 : 0.8});
    };
    join(x + 1, y, idAt(x + 1, y));
    join(y + 1, x, idAt(x, y + 1));
  }

  std::mt19937 random_{3};
  std::normal_distribution<float> normal_;
  std::uint64_t side_ = 0;
  PlaceGraph places_;
};

SceneGraphConfig makeConfig() {
  SceneGraphConfig config;
  config.place_alpha = 0.0;
  return config;
}

/// From a graph to its clusters: `setPlaces` (looking for changes, smoothing) and clustering.
void clustersAfterTenPlacesSeenAgain(benchmark::State& state) {
  Building building(static_cast<std::uint64_t>(state.range(0)));
  RegionLayer layer(makeConfig());
  layer.setTasks(building.tasks);
  layer.setPlaces(building.seeAgain(0));
  layer.computeClusters();
  std::size_t num_regions = 0;
  for (auto _ : state) {
    state.PauseTiming();
    PlaceGraphPtr places = building.seeAgain(10);
    state.ResumeTiming();
    layer.setPlaces(places);
    num_regions = layer.computeClusters().size();
    places.reset();
  }
  state.counters["regions"] = static_cast<double>(num_regions);
}
BENCHMARK(clustersAfterTenPlacesSeenAgain)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

/// The same with names, areas and footprints, and what joining neighbours would lose.
void regionsAfterTenPlacesSeenAgain(benchmark::State& state) {
  Building building(static_cast<std::uint64_t>(state.range(0)));
  SceneGraphBuilder builder(makeConfig());
  builder.setPlaceTasks(building.tasks);
  builder.setPlaces(building.seeAgain(0));
  builder.snapshot();
  std::size_t num_regions = 0;
  for (auto _ : state) {
    state.PauseTiming();
    PlaceGraphPtr places = building.seeAgain(10);
    state.ResumeTiming();
    builder.setPlaces(places);
    num_regions = builder.snapshot()->regions.size();
    places.reset();
  }
  state.counters["regions"] = static_cast<double>(num_regions);
}
BENCHMARK(regionsAfterTenPlacesSeenAgain)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

/// Of it, what is spent where nothing has changed; with embeddings of their own these are read.
void comparePlacesThatDidNotChange(benchmark::State& state) {
  Building building(static_cast<std::uint64_t>(state.range(0)));
  RegionLayer layer(makeConfig());
  layer.setTasks(building.tasks);
  const bool is_shared = state.range(1) != 0;
  const PlaceGraphPtr copies[] = {building.seeAgain(0),
                                  is_shared ? building.seeAgain(0) : building.readAnew()};
  int turn = 0;
  for (auto _ : state) layer.setPlaces(copies[++turn % 2]);
}
BENCHMARK(comparePlacesThatDidNotChange)
    ->ArgNames({"places", "shared"})
    ->Args({1000, 1})
    ->Args({10000, 1})
    ->Args({10000, 0})
    ->Unit(benchmark::kMillisecond);

void regionsInBatch(benchmark::State& state) {
  Building building(static_cast<std::uint64_t>(state.range(0)));
  const PlaceGraphPtr places = building.seeAgain(0);
  for (auto _ : state) {
    RegionLayer layer(makeConfig());
    layer.setTasks(building.tasks);
    layer.setPlaces(places);
    benchmark::DoNotOptimize(layer.computeClusters());
  }
}
BENCHMARK(regionsInBatch)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

void geometricRooms(benchmark::State& state) {
  Building building(static_cast<std::uint64_t>(state.range(0)));
  const PlaceGraphPtr places = building.seeAgain(0);
  for (auto _ : state) benchmark::DoNotOptimize(computeGeometricRooms(*places, {}));
}
BENCHMARK(geometricRooms)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tsg::scene_graph

BENCHMARK_MAIN();
