// SPDX-License-Identifier: BSD-3-Clause
// Agglomerative information bottleneck beside a dense reference and one that works as the published
// implementation does. Scenes: cubes of 1 m, each overlapping about 12 others, in patches of 3 m
// that serve the same tasks; half of the patches serve none. 25 tasks, embeddings of 768.
// `peak_MB` is what the clustering adds to the process's memory at most, the scene not included.

#include <benchmark/benchmark.h>

#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "bottleneck_reference.h"
#include "peak_memory.h"
#include "rescan_reference.h"
#include "task_scene_graph/bottleneck/clustering.h"

namespace {

using namespace tsg;
using bottleneck::Adjacency;
using bottleneck::ClusteringConfig;
using bottleneck::IncrementalClustering;
using bottleneck::NodeKey;

constexpr int kDimension = 768;
constexpr int kNumTasks = 25;
constexpr double kPatch_m = 3.0;

class Scene {
 public:
  explicit Scene(double side_m) : side_m_(side_m), tasks_(kNumTasks, kDimension) {
    for (int j = 0; j < kNumTasks; ++j) tasks_.row(j) = makeNoise().transpose();
  }
  const EmbeddingMatrix& tasks() const { return tasks_; }

  Aabb makeBox(const Eigen::Vector3d& origin_m = Eigen::Vector3d::Zero()) {
    std::uniform_real_distribution<double> place(0.0, side_m_);
    const Eigen::Vector3d min(place(random_), place(random_), place(random_));
    return makeAabb(origin_m + min, origin_m + min + Eigen::Vector3d::Ones());
  }

  Embedding makeEmbedding(const Aabb& box) {
    Embedding x = makeNoise();
    const auto cell = (box.min() / kPatch_m).array().floor().cast<std::int64_t>();
    const auto hash =
        static_cast<std::uint64_t>(cell[0] * 73856093 ^ cell[1] * 19349663 ^ cell[2] * 83492791);
    std::mt19937 patch(static_cast<std::uint32_t>(hash ^ (hash >> 29)));
    if (patch() % 2 == 0) return x;
    std::uniform_real_distribution<float> share(0.15f, 0.45f);
    x += share(random_) * tasks_.row(patch() % kNumTasks).transpose();
    x += share(random_) * tasks_.row(random_() % kNumTasks).transpose();
    return x;
  }

 private:
  Embedding makeNoise() {
    Embedding noise(kDimension);
    for (Eigen::Index i = 0; i < noise.size(); ++i) {
      noise[i] = static_cast<float>(random_() % 65536) - 32767.5f;
    }
    return noise / noise.norm();
  }

  double side_m_;
  std::mt19937 random_{7};
  EmbeddingMatrix tasks_;
};

struct FixedScene {
  explicit FixedScene(std::int64_t count) : scene(std::cbrt(static_cast<double>(count) * 8 / 12)) {
    for (std::int64_t i = 0; i < count; ++i) {
      boxes.push_back(scene.makeBox());
      embeddings.push_back(scene.makeEmbedding(boxes.back()));
    }
  }
  Scene scene;
  std::vector<Aabb> boxes;
  std::vector<Embedding> embeddings;
};

IncrementalClustering cluster(const FixedScene& scene, double delta) {
  ClusteringConfig config;
  config.delta = delta;
  IncrementalClustering clustering(config, Adjacency::kBoxOverlap);
  clustering.setTasks(scene.scene.tasks());
  for (std::size_t i = 0; i < scene.boxes.size(); ++i) {
    clustering.insert(i, scene.embeddings[i], scene.boxes[i]);
  }
  clustering.clusterOf(0);
  return clustering;
}

void reportBatch(benchmark::State& state, IncrementalClustering& clustering) {
  const auto count = [&](const ClusteringConfig& config) {
    clustering.setConfig(config);
    return static_cast<double>(clustering.clusters().size());
  };
  ClusteringConfig config;
  config.normaliser = bottleneck::Normaliser::kSizeInvariant;
  const bottleneck::ClusteringStatistics statistics = clustering.statistics();
  state.counters["merges"] = static_cast<double>(statistics.deltas.size());
  state.counters["scoring_ms"] = 1e3 * statistics.scoring_s;
  state.counters["adjacency_ms"] = 1e3 * statistics.adjacency_s;
  state.counters["tapes_ms"] = 1e3 * statistics.agglomeration_s;
  state.counters["paper_clusters"] = count(ClusteringConfig());
  state.counters["size_invariant_clusters"] = count(config);
}

// Insertion, relevance, overlaps and every merge to the end of the tape. Counters: how many
// clusters the default thresholds of both normalisers give, and wall times of the parts.
void BM_Batch(benchmark::State& state) {
  const FixedScene scene(state.range(0));
  const test::PeakMemory memory;
  double peak_MB = 0.0;
  for (auto _ : state) {
    std::optional<IncrementalClustering> clustering = cluster(scene, 1.0);
    state.PauseTiming();
    if (peak_MB == 0.0) peak_MB = memory.peak_MB();
    reportBatch(state, *clustering);
    clustering.reset();
    state.ResumeTiming();
  }
  state.counters["peak_MB"] = peak_MB;
  state.counters["primitives/s"] = benchmark::Counter(
      static_cast<double>(state.range(0)), benchmark::Counter::kIsIterationInvariantRate);
  state.SetComplexityN(state.range(0));
}
BENCHMARK(BM_Batch)
    ->Arg(2000)
    ->Arg(5000)
    ->Arg(10000)
    ->Arg(20000)
    ->Arg(50000)
    ->Arg(100000)
    ->Arg(200000)
    ->Unit(benchmark::kMillisecond)
    ->Complexity(benchmark::oNLogN);

void BM_RescanEveryMerge(benchmark::State& state) {
  const FixedScene scene(state.range(0));
  const test::PeakMemory memory;
  std::size_t num_merges = 0;
  for (auto _ : state) {
    num_merges =
        test::clusterByRescanning(scene.embeddings, scene.boxes, scene.scene.tasks(), 0.23);
  }
  state.counters["merges"] = static_cast<double>(num_merges);
  state.counters["peak_MB"] = memory.peak_MB();
}
BENCHMARK(BM_RescanEveryMerge)->Arg(2000)->Arg(20000)->Unit(benchmark::kMillisecond)->Iterations(1);

void BM_DenseReference(benchmark::State& state) {
  const FixedScene fixed(state.range(0));
  test::ReferenceScene scene;
  scene.tasks = fixed.scene.tasks();
  for (std::size_t i = 0; i < fixed.boxes.size(); ++i) {
    scene.primitives[i] = {fixed.embeddings[i], fixed.boxes[i]};
  }
  ClusteringConfig config;
  config.delta = 1.0;
  const test::PeakMemory memory;
  for (auto _ : state) {
    benchmark::DoNotOptimize(test::clusterDense(scene, test::findOverlaps(scene), config));
  }
  state.counters["peak_MB"] = memory.peak_MB();
}
BENCHMARK(BM_DenseReference)->Arg(100)->Arg(200)->Unit(benchmark::kMillisecond);

// Between the paper's threshold and a tenth of it.
void BM_DeltaChange(benchmark::State& state) {
  const FixedScene scene(state.range(0));
  IncrementalClustering clustering = cluster(scene, 1e-5);
  state.counters["coarse_clusters"] = static_cast<double>(clustering.clusters().size());
  const test::PeakMemory memory;
  bool is_coarse = true;
  for (auto _ : state) {
    is_coarse = !is_coarse;
    clustering.setDelta(is_coarse ? 1e-5 : 1e-6);
    benchmark::DoNotOptimize(clustering.clusterOf(0));
  }
  clustering.setDelta(1e-6);
  state.counters["fine_clusters"] = static_cast<double>(clustering.clusters().size());
  state.counters["peak_MB"] = memory.peak_MB();
}
BENCHMARK(BM_DeltaChange)->Arg(20000)->Arg(100000)->Unit(benchmark::kMillisecond);

void BM_AlphaChange(benchmark::State& state) {
  const FixedScene scene(state.range(0));
  IncrementalClustering clustering = cluster(scene, 1e-5);
  const test::PeakMemory memory;
  bool is_high = false;
  for (auto _ : state) {
    is_high = !is_high;
    clustering.setAlpha(is_high ? 0.26 : 0.23);
    benchmark::DoNotOptimize(clustering.clusterOf(0));
  }
  state.counters["peak_MB"] = memory.peak_MB();
}
BENCHMARK(BM_AlphaChange)->Arg(100000)->Unit(benchmark::kMillisecond);

void BM_TaskChange(benchmark::State& state) {
  const FixedScene scene(state.range(0));
  IncrementalClustering clustering = cluster(scene, 1e-5);
  const EmbeddingMatrix others = scene.scene.tasks().topRows(20);
  const test::PeakMemory memory;
  bool is_shorter = false;
  for (auto _ : state) {
    is_shorter = !is_shorter;
    clustering.setTasks(is_shorter ? others : scene.scene.tasks());
    benchmark::DoNotOptimize(clustering.clusterOf(0));
  }
  state.counters["peak_MB"] = memory.peak_MB();
}
BENCHMARK(BM_TaskChange)->Arg(100000)->Unit(benchmark::kMillisecond);

// Ten primitives into ten of the map's rooms of 100.
void BM_InsertTenIntoRooms(benchmark::State& state) {
  const std::int64_t num_rooms = state.range(0) / 100;
  Scene scene(std::cbrt(100.0 * 8 / 12));
  const auto originOf = [](std::int64_t room) {
    return Eigen::Vector3d(20.0 * static_cast<double>(room % 1000),
                           20.0 * static_cast<double>(room / 1000), 0.0);
  };
  const test::PeakMemory memory;
  IncrementalClustering clustering(ClusteringConfig(), Adjacency::kBoxOverlap);
  clustering.setTasks(scene.tasks());
  NodeKey next = 0;
  const auto insert = [&](std::int64_t room) {
    const Aabb box = scene.makeBox(originOf(room));
    clustering.insert(next++, scene.makeEmbedding(box), box);
  };
  for (std::int64_t i = 0; i < state.range(0); ++i) insert(i / 100);
  clustering.applyChanges();
  std::mt19937 random(3);
  for (auto _ : state) {
    state.PauseTiming();
    std::vector<Aabb> boxes;
    std::vector<Embedding> embeddings;
    for (int i = 0; i < 10; ++i) {
      boxes.push_back(scene.makeBox(originOf(static_cast<std::int64_t>(random()) % num_rooms)));
      embeddings.push_back(scene.makeEmbedding(boxes.back()));
    }
    state.ResumeTiming();
    for (std::size_t i = 0; i < 10; ++i) clustering.insert(next + i, embeddings[i], boxes[i]);
    benchmark::DoNotOptimize(clustering.applyChanges());
    state.PauseTiming();
    for (std::size_t i = 0; i < 10; ++i) clustering.erase(next + i);
    clustering.applyChanges();
    state.ResumeTiming();
  }
  state.counters["peak_MB"] = memory.peak_MB();
}
BENCHMARK(BM_InsertTenIntoRooms)
    ->RangeMultiplier(10)
    ->Range(1000, 1000000)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(200);

// One primitive into one component that everything belongs to. The tape follows the former one:
// `tape_ms` beside `fresh_tape_ms` is what that saves (wall time).
void BM_InsertIntoGiantComponent(benchmark::State& state) {
  FixedScene scene(state.range(0));
  IncrementalClustering clustering = cluster(scene, 1e-5);
  state.counters["fresh_tape_ms"] = 1e3 * clustering.statistics().agglomeration_s;
  double tape_ms = 0.0;
  const auto key = static_cast<NodeKey>(state.range(0));
  const test::PeakMemory memory;
  for (auto _ : state) {
    state.PauseTiming();
    const Aabb box = scene.scene.makeBox();
    const Embedding embedding = scene.scene.makeEmbedding(box);
    state.ResumeTiming();
    clustering.insert(key, embedding, box);
    benchmark::DoNotOptimize(clustering.clusterOf(key));
    state.PauseTiming();
    tape_ms += 1e3 * clustering.statistics().agglomeration_s;
    clustering.erase(key);
    clustering.clusterOf(0);
    state.ResumeTiming();
  }
  state.counters["tape_ms"] = benchmark::Counter(tape_ms, benchmark::Counter::kAvgIterations);
  state.counters["peak_MB"] = memory.peak_MB();
}
BENCHMARK(BM_InsertIntoGiantComponent)
    ->Arg(1000)
    ->Arg(10000)
    ->Arg(100000)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(20);

}  // namespace

BENCHMARK_MAIN();
