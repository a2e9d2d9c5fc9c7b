// SPDX-License-Identifier: BSD-3-Clause
// Cost of mapping per frame; reading and decoding images is not counted.
#include <benchmark/benchmark.h>

#include <cmath>
#include <map>
#include <string>

#include "sequence.h"
#include "support.h"
#include "synthetic_scene.h"
#include "task_scene_graph/mapping/background_map.h"
#include "task_scene_graph/mapping/depth_filter.h"
#include "task_scene_graph/mapping/occupancy_map.h"

namespace tsg::mapping {
namespace {

/// A furnished room in closed form, walked round.
std::vector<RgbdFrame> renderFrames(int count) {
  using Eigen::Vector3d;
  const std::vector<test::Solid> scene{
      test::makePlane({0, 0, 0}, {0, 0, 1}, {90, 90, 90}),
      test::makePlane({3, 0, 0}, {-1, 0, 0}, {10, 200, 30}),
      test::makePlane({-3, 0, 0}, {1, 0, 0}, {10, 20, 230}),
      test::makePlane({0, 3, 0}, {0, -1, 0}, {130, 20, 30}),
      test::makePlane({0, -3, 0}, {0, 1, 0}, {130, 200, 30}),
      test::makeBox({Vector3d(-0.6, -0.4, 0.7), Vector3d(0.6, 0.4, 0.75)}, {120, 80, 30}, 1),
      test::makeBox({Vector3d(-0.1, -0.1, 0.75), Vector3d(0.1, 0.1, 1.0)}, {200, 40, 20}, 2),
      test::makeSphere({1.6, 1.0, 0.4}, 0.4, {20, 40, 200}, 3)};
  std::vector<RgbdFrame> frames;
  for (int i = 0; i < count; ++i) {
    const double angle = 0.1 * i;
    const Vector3d eye(1.8 * std::cos(angle), 1.8 * std::sin(angle), 1.4);
    frames.push_back(
        test::render(scene, {640, 480, 525, 525, 319.5, 239.5}, test::lookAt(eye, {-0.2, 0, 0.6}))
            .frame);
  }
  return frames;
}

/// Every fifth frame of a recorded sequence; empty if it is not here.
std::vector<RgbdFrame> loadFrames(const std::string& sequence) {
  std::vector<RgbdFrame> frames;
  const auto shared = test::findSharedFolder();
  if (!shared || !std::filesystem::exists(*shared / "data" / sequence)) return frames;
  for (int i = 0; i < 300; i += 5) {
    frames.push_back(test::loadSequenceFrame(*shared / "data" / sequence, i));
  }
  return frames;
}

const std::vector<RgbdFrame>& findFrames(const std::string& name) {
  static std::map<std::string, std::vector<RgbdFrame>> cache;
  auto [entry, is_new] = cache.try_emplace(name);
  if (is_new) entry->second = name == "room" ? renderFrames(8) : loadFrames(name);
  return entry->second;
}

IntegratorConfig makeConfig(const benchmark::State& state) {
  IntegratorConfig config;
  config.voxel_size_m = 0.01 * static_cast<double>(state.range(0));
  config.truncation_m = 4.0 * config.voxel_size_m;
  config.num_threads = static_cast<int>(state.range(1));
  return config;
}

void setSecondsPerFrame(benchmark::State& state, double frames) {
  state.counters["s/frame"] =
      benchmark::Counter(frames, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

/// Arguments: voxel size in centimetres, threads. The map grows from nothing.
void integrateSequence(benchmark::State& state, const char* sequence, bool carve) {
  const auto& frames = findFrames(sequence);
  if (frames.empty()) {
    state.SkipWithError("the sequence is not here (set TSG_SHARED)");
    return;
  }
  IntegratorConfig config = makeConfig(state);
  config.carve_free_space = carve;
  config.with_color = !carve;
  std::size_t voxels = 0;
  for (auto _ : state) {
    TsdfIntegrator integrator(config);
    TsdfVolume volume(config.voxel_size_m);
    for (const auto& frame : frames) {
      voxels += integrator.integrate(frame, volume).num_updated_voxels;
    }
  }
  const auto count = static_cast<double>(state.iterations()) * static_cast<double>(frames.size());
  setSecondsPerFrame(state, count);
  state.counters["voxels/frame"] = static_cast<double>(voxels) / count;
}

/// Argument: resolution in centimetres. The octree grows from nothing.
void integrateOccupancy(benchmark::State& state, const char* sequence) {
  const auto& frames = findFrames(sequence);
  if (frames.empty()) {
    state.SkipWithError("the sequence is not here (set TSG_SHARED)");
    return;
  }
  OccupancyConfig config;
  config.resolution_m = 0.01 * static_cast<double>(state.range(0));
  std::size_t changes = 0;
  for (auto _ : state) {
    OccupancyMap map(config);
    for (const auto& frame : frames) {
      map.integrate(frame);
      changes += map.takeChanges().size();
    }
  }
  const auto count = static_cast<double>(state.iterations()) * static_cast<double>(frames.size());
  setSecondsPerFrame(state, count);
  state.counters["changes/frame"] = static_cast<double>(changes) / count;
}

/// A frame, then an update of the mesh; only the update is timed.
void updateMesh(benchmark::State& state, const char* sequence) {
  const auto& frames = findFrames(sequence);
  if (frames.empty()) {
    state.SkipWithError("the sequence is not here (set TSG_SHARED)");
    return;
  }
  BackgroundConfig config;
  config.tsdf = makeConfig(state);
  BackgroundMap map(config);
  std::size_t next = 0;
  for (auto _ : state) {
    state.PauseTiming();
    map.integrate(frames[next++ % frames.size()]);
    state.ResumeTiming();
    benchmark::DoNotOptimize(map.updateMesh());
  }
  state.counters["blocks/s"] = benchmark::Counter(
      static_cast<double>(map.counters().blocks_remeshed), benchmark::Counter::kIsRate);
}

/// Argument: radius of the bilateral filter, pixels.
void filterDepth(benchmark::State& state, const char* sequence) {
  const auto& frames = findFrames(sequence);
  if (frames.empty()) {
    state.SkipWithError("the sequence is not here (set TSG_SHARED)");
    return;
  }
  DepthFilterConfig config;
  config.bilateral_radius_px = static_cast<int>(state.range(0));
  DepthFilter filter(config);
  std::size_t next = 0;
  for (auto _ : state) {
    const auto& frame = frames[next++ % frames.size()];
    benchmark::DoNotOptimize(filter.apply(frame.depth, frame.camera));
  }
  state.counters["rejected_share"] = static_cast<double>(filter.counters().rejected_readings) /
                                     static_cast<double>(filter.counters().valid_readings);
}

BENCHMARK_CAPTURE(integrateSequence, room, "room", false)
    ->Args({5, 1})
    ->Args({2, 1})
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(integrateSequence, room_carving, "room", true)
    ->Args({10, 1})
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(integrateSequence, kitchen, "kitchen", false)
    ->Args({5, 1})
    ->Args({2, 1})
    ->Args({2, 2})
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(integrateSequence, kitchen_carving, "kitchen", true)
    ->Args({10, 1})
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(integrateSequence, house_a, "house_a", false)
    ->Args({5, 1})
    ->Args({2, 1})
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(integrateSequence, house_a_carving, "house_a", true)
    ->Args({10, 1})
    ->Unit(benchmark::kMillisecond);

BENCHMARK_CAPTURE(integrateOccupancy, room, "room")->Arg(10)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(integrateOccupancy, kitchen, "kitchen")
    ->Arg(10)
    ->Arg(5)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(integrateOccupancy, house_a, "house_a")
    ->Arg(10)
    ->Arg(5)
    ->Unit(benchmark::kMillisecond);

BENCHMARK_CAPTURE(filterDepth, room, "room")->Arg(0)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(filterDepth, kitchen, "kitchen")->Arg(0)->Arg(2)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(filterDepth, house_a, "house_a")->Arg(0)->Unit(benchmark::kMillisecond);

BENCHMARK_CAPTURE(updateMesh, room, "room")->Args({5, 1})->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(updateMesh, kitchen, "kitchen")->Args({5, 1})->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tsg::mapping

BENCHMARK_MAIN();
