// SPDX-License-Identifier: BSD-3-Clause
// Cost of mapping per frame; reading and decoding images is not counted.
#include <benchmark/benchmark.h>

#include "sequence.h"
#include "support.h"
#include "task_scene_graph/mapping/tsdf_integrator.h"

namespace task_scene_graph::mapping {
namespace {

std::vector<RgbdFrame> loadFrames(const char* sequence, int step) {
  std::vector<RgbdFrame> frames;
  const auto shared = test::findSharedFolder();
  if (!shared || !std::filesystem::exists(*shared / "data" / sequence)) return frames;
  for (int i = 0; i < 300; i += step) {
    frames.push_back(test::loadSequenceFrame(*shared / "data" / sequence, i));
  }
  return frames;
}

void integrateSequence(benchmark::State& state, const char* sequence, bool carve) {
  static std::map<std::string, std::vector<RgbdFrame>> cache;
  auto& frames = cache[sequence];
  if (frames.empty()) frames = loadFrames(sequence, 5);
  if (frames.empty()) {
    state.SkipWithError("the sequence is not here");
    return;
  }
  IntegratorConfig config;
  config.voxel_size_m = 0.01 * static_cast<double>(state.range(0));
  config.truncation_m = 4.0 * config.voxel_size_m;
  config.num_threads = static_cast<int>(state.range(1));
  config.carve_free_space = carve;
  config.with_color = !carve;
  std::size_t voxels = 0;
  std::size_t blocks = 0;
  for (auto _ : state) {
    TsdfIntegrator integrator(config);
    TsdfVolume volume(config.voxel_size_m);
    for (const auto& frame : frames) {
      const auto result = integrator.integrate(frame, volume);
      voxels += result.num_updated_voxels;
      blocks += result.observed_blocks.size();
    }
  }
  const auto count = static_cast<double>(state.iterations()) * static_cast<double>(frames.size());
  state.counters["s/frame"] =
      benchmark::Counter(count, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["voxels/frame"] = static_cast<double>(voxels) / count;
  state.counters["blocks/frame"] = static_cast<double>(blocks) / count;
}

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

}  // namespace
}  // namespace task_scene_graph::mapping

BENCHMARK_MAIN();
