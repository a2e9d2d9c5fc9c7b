// SPDX-License-Identifier: BSD-3-Clause
// What the plausibility report costs on a walk through a generated apartment: us per frame at
// 160x120 and 640x480, ms for the report as a whole and when nothing is new.
#include <benchmark/benchmark.h>

#include "rgbd_faults.h"
#include "task_scene_graph/plausibility/input_plausibility.h"

namespace tsg::plausibility {
namespace {

/// 60 frames at 10 Hz; rendered once for each size.
const test::RgbdWalk& walk(int width_px) {
  static const test::RgbdWalk small = test::makeApartmentWalk(1, 160, 100, 60);
  if (width_px == 160) return small;
  static const test::RgbdWalk large = test::makeApartmentWalk(1, 640, 100, 60);
  return large;
}

void addWalk(InputPlausibility& plausibility, const test::RgbdWalk& frames) {
  for (const RgbdFrame& frame : frames) plausibility.addFrame(frame);
}

/// Hours of it: groups of views have become rare.
void benchmarkAddFrame(benchmark::State& state) {
  const test::RgbdWalk& frames = walk(static_cast<int>(state.range(0)));
  InputPlausibility plausibility;
  std::int64_t offset_ns = 0;
  for (auto _ : state) {
    state.PauseTiming();
    test::RgbdWalk later = frames;
    for (RgbdFrame& frame : later) frame.stamp.ns += offset_ns;
    offset_ns += 6'000'000'000;
    state.ResumeTiming();
    addWalk(plausibility, later);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(frames.size()));
  state.counters["us/frame"] = benchmark::Counter(
      static_cast<double>(frames.size()) * 1e-6,
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(benchmarkAddFrame)->Arg(160)->Arg(640)->Unit(benchmark::kMillisecond);

/// The first seconds: every group is new.
void benchmarkAddFirstFrames(benchmark::State& state) {
  const test::RgbdWalk& frames = walk(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    InputPlausibility plausibility;
    addWalk(plausibility, frames);
    benchmark::DoNotOptimize(plausibility);
  }
  state.counters["us/frame"] = benchmark::Counter(
      static_cast<double>(frames.size()) * 1e-6,
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(benchmarkAddFirstFrames)->Arg(160)->Arg(640)->Unit(benchmark::kMillisecond);

void benchmarkFirstReport(benchmark::State& state) {
  for (auto _ : state) {
    state.PauseTiming();
    InputPlausibility plausibility;
    addWalk(plausibility, walk(160));
    state.ResumeTiming();
    benchmark::DoNotOptimize(plausibility.findings());
  }
}
BENCHMARK(benchmarkFirstReport)->Unit(benchmark::kMillisecond);

/// With a fault, more ways of reading the input are tried.
void benchmarkFirstReportOfAFault(benchmark::State& state) {
  const test::RgbdWalk frames = test::withDepthTimes(test::withInversePoses(walk(160)), 0.2);
  for (auto _ : state) {
    state.PauseTiming();
    InputPlausibility plausibility;
    addWalk(plausibility, frames);
    state.ResumeTiming();
    benchmark::DoNotOptimize(plausibility.findings());
  }
}
BENCHMARK(benchmarkFirstReportOfAFault)->Unit(benchmark::kMillisecond);

void benchmarkReportAgain(benchmark::State& state) {
  InputPlausibility plausibility;
  addWalk(plausibility, walk(160));
  benchmark::DoNotOptimize(plausibility.findings());
  for (auto _ : state) benchmark::DoNotOptimize(plausibility.findings());
}
BENCHMARK(benchmarkReportAgain)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tsg::plausibility

BENCHMARK_MAIN();
