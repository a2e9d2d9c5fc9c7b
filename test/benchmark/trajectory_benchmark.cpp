// SPDX-License-Identifier: BSD-3-Clause
// Pose graphs of laps around a block of 20 x 10 m with a keyframe each 0.5 m (argument: keyframes)
// and a loop closure each 5 m from the second lap on.
#include <benchmark/benchmark.h>

#include "graph_worlds.h"

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

}  // namespace
}  // namespace tsg::trajectory

BENCHMARK_MAIN();
