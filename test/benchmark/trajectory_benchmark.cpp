// SPDX-License-Identifier: BSD-3-Clause
// Pose graphs of laps around a block of 20 x 10 m with a keyframe each 0.5 m (argument: keyframes)
// and a loop closure each 5 m from the second lap on.
#include <benchmark/benchmark.h>

#include "graph_worlds.h"
#include "task_scene_graph/trajectory/correct_map.h"

namespace tsg::trajectory {
namespace {

void addAll(const std::vector<PoseEdge>& edges, PoseGraph& graph) {
  for (const PoseEdge& edge : edges) graph.addEdge(edge);
}

void optimize(PoseGraph& graph, benchmark::State& state) {
  const SolveReport report = graph.optimize();
  if (report.isFault()) state.SkipWithError(report.message.c_str());
  state.counters["rounds"] = report.num_rounds;
  state.counters["iterations"] = report.num_iterations;
  state.counters["rejected"] = report.num_rejected;
}

/// From odometry, all loop closures new.
void BM_SolveAllLoops(benchmark::State& state) {
  LapWorld world = makeLaps(static_cast<int>(state.range(0)), 1);
  addAll(world.loops, world.graph);
  for ([[maybe_unused]] auto _ : state) {
    PoseGraph graph = world.graph;
    optimize(graph, state);
  }
}
BENCHMARK(BM_SolveAllLoops)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

/// A solved graph, and one more loop closure at its end.
void BM_SolveOneMoreLoop(benchmark::State& state) {
  LapWorld world = makeLaps(static_cast<int>(state.range(0)), 1);
  const PoseEdge last = world.loops.back();
  world.loops.pop_back();
  addAll(world.loops, world.graph);
  world.graph.optimize();
  world.graph.addEdge(last);
  for ([[maybe_unused]] auto _ : state) {
    PoseGraph graph = world.graph;
    optimize(graph, state);
  }
}
BENCHMARK(BM_SolveOneMoreLoop)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

/// From odometry, 30 % of the loop closures wrong.
void BM_SolveWithFalseLoops(benchmark::State& state) {
  LapWorld world = makeLaps(static_cast<int>(state.range(0)), 1);
  const std::size_t count = world.loops.size() * 3 / 7;
  addAll(world.loops, world.graph);
  addAll(makeFalseLoops(count, world.truth.size(), 2), world.graph);
  for ([[maybe_unused]] auto _ : state) {
    PoseGraph graph = world.graph;
    optimize(graph, state);
  }
}
BENCHMARK(BM_SolveWithFalseLoops)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

Mesh makePatch(const Eigen::Vector3f& corner_m, std::uint32_t side) {
  Mesh mesh;
  const float step_m = 0.4F / static_cast<float>(side);
  for (std::uint32_t i = 0; i < side * side; ++i) {
    mesh.vertices.push_back(corner_m + step_m * Eigen::Vector3f(static_cast<float>(i % side) + 0.5F,
                                                                static_cast<float>(i / side) + 0.5F,
                                                                0.5F));
    if (i % side + 1 == side || i / side + 1 == side) continue;
    mesh.triangles.push_back({i, i + 1, i + side});
    mesh.triangles.push_back({i + 1, i + side + 1, i + side});
  }
  mesh.colors.resize(mesh.vertices.size());
  return mesh;
}

map::Map makeMap(const Keyframes& keyframes) {
  map::Map map("map");
  std::vector<ObjectPrimitivePtr> primitives;
  for (std::uint64_t i = 1; i <= 2000; ++i) {
    const Keyframe& seen = keyframes.list()[i % keyframes.list().size()];
    auto primitive = std::make_shared<ObjectPrimitive>();
    primitive->id = PrimitiveId{i};
    primitive->mesh = makePatch(seen.T_world_camera.translation().cast<float>(), 22);
    primitive->box = primitive->mesh.computeBounds();
    primitive->oriented_box = computeOrientedBox(primitive->mesh.vertices);
    primitive->first_seen = primitive->last_seen = primitive->views.best.stamp = seen.stamp;
    primitives.push_back(primitive);
  }
  map.addPrimitives(std::move(primitives));
  auto places = std::make_shared<PlaceGraph>();
  for (std::uint64_t i = 0; i < 10000; ++i) {
    const double x_m = 0.2 * static_cast<double>(i % 100);
    const double y_m = 0.1 * static_cast<double>(i / 100);
    places->places.push_back({PlaceId{i + 1}, {x_m, y_m, 1.0}, 0.5, {}, 0});
  }
  map.setPlaces(places);
  std::vector<mapping::BlockMesh> blocks;
  for (int i = 0; i < 5000; ++i) {
    const mapping::GridIndex index(i % 50, i / 50 % 25, i / 1250);
    blocks.push_back(
        {index, std::make_shared<const Mesh>(makePatch(index.cast<float>() * 0.4F, 20))});
  }
  map.setMesh(0.05, std::move(blocks));
  return map;
}

/// Argument: 0 all keyframes move alike, 1 each a bit more than the one before.
void BM_CorrectMap(benchmark::State& state) {
  Keyframes keyframes("map");
  std::vector<KeyframeMotion> motions;
  for (int i = 0; i < 1000; ++i) {
    Pose pose = computeLapPose(i);
    pose.translation().x() += 1e-3 * i;
    const auto id = keyframes.add({i * 500'000'000LL}, pose);
    const double share = state.range(0) == 0 ? 1.0 : i / 1000.0;
    if (id) motions.push_back({*id, makePose(0.5 * share, 0.2 * share, 0.0, 0.1 * share)});
  }
  const Correction correction(motions);
  const map::Map map = makeMap(keyframes);
  std::size_t moved = 0;
  for ([[maybe_unused]] auto _ : state) {
    moved = correctMap(map, keyframes, correction).num_moved_blocks;
  }
  state.counters["moved_blocks"] = static_cast<double>(moved);
}
BENCHMARK(BM_CorrectMap)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tsg::trajectory

BENCHMARK_MAIN();
