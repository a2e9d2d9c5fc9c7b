// SPDX-License-Identifier: BSD-3-Clause
// Place graph of a building of rooms of 5 x 5 m joined by doors and of a corridor: an update after
// the blocks of one room, or of a window of 8 m at the corridor's end, changed, beside one
// computation with everything; taking in a view; the exact distance transform beside exhaustive
// search on the same grid.
#include <benchmark/benchmark.h>
#include <malloc.h>

#include <cmath>
#include <limits>
#include <random>

#include "task_scene_graph/places/dense_grid.h"
#include "task_scene_graph/places/place_extractor.h"

namespace tsg::places {
namespace {

using mapping::GridIndex;

/// Signed distance of a wall lattice (period 5 m, 0.2 m thick, doors of 0.9 m in the middle).
double computeWallDistance(double along_m, double across_m) {
  const double to_wall_m = std::abs(across_m - 5.0 * std::round(across_m / 5.0)) - 0.1;
  const double to_door_m = std::abs(along_m - 5.0 * std::floor(along_m / 5.0) - 2.5) - 0.45;
  return to_door_m < 0.0 ? std::hypot(std::max(0.0, to_wall_m), to_door_m) : to_wall_m;
}

/// `rooms` x `rooms` rooms, all of it observed up to 2.4 m.
mapping::TsdfVolume makeBuilding(int rooms) {
  mapping::TsdfVolume volume(0.1);
  const int cells = 50 * rooms;
  for (int z = -2; z < 24; ++z) {
    for (int y = 0; y < cells; ++y) {
      for (int x = 0; x < cells; ++x) {
        const Eigen::Vector3d p = volume.computeVoxelCenter({x, y, z});
        const double distance_m =
            std::min({p.z(), computeWallDistance(p.x(), p.y()), computeWallDistance(p.y(), p.x())});
        auto& block = volume.allocateBlock(mapping::TsdfVolume::computeBlockIndex({x, y, z}));
        auto& voxel = block.voxels[static_cast<std::size_t>(mapping::TsdfBlock::computeLinearIndex(
            mapping::TsdfVolume::computeLocalIndex({x, y, z})))];
        if (distance_m < -0.3) continue;
        voxel.distance_m = static_cast<float>(std::min(distance_m, 0.3));
        voxel.weight = 1.0F;
      }
    }
  }
  return volume;
}

std::vector<GridIndex> findRoomBlocks(const mapping::TsdfVolume& volume) {
  std::vector<GridIndex> blocks;
  for (const GridIndex& block : volume.sortedBlockIndices()) {
    if (block.x() < 6 && block.y() < 6) blocks.push_back(block);
  }
  return blocks;
}

void updateOneRoom(benchmark::State& state) {
  const auto volume = makeBuilding(static_cast<int>(state.range(0)));
  const auto blocks = findRoomBlocks(volume);
  PlacesConfig config;
  if (state.range(1) == 1) config.free_space = FreeSpaceKind::kVolume;
  PlaceExtractor extractor(config);
  extractor.update(volume, volume.sortedBlockIndices(), Stamp{1});
  for (auto _ : state) extractor.update(volume, blocks, Stamp{2});
  state.counters["places"] = static_cast<double>(extractor.graph().places.size());
  state.counters["blocks"] = static_cast<double>(volume.blocks().size());
}
BENCHMARK(updateOneRoom)
    ->ArgNames({"rooms_per_side", "volume"})
    ->Args({1, 0})
    ->Args({4, 0})
    ->Args({10, 0})
    ->Args({1, 1})
    ->Args({4, 1})
    ->Unit(benchmark::kMillisecond);

/// A corridor 2.4 m wide along x with a pillar every 5 m, walked; observed up to 2.4 m.
mapping::TsdfVolume makeCorridor(int length_m) {
  mapping::TsdfVolume volume(0.1);
  for (int x = 0; x < 10 * length_m; ++x) {
    for (int y = -2; y < 26; ++y) {
      for (int z = -2; z < 24; ++z) {
        const Eigen::Vector3d p = volume.computeVoxelCenter({x, y, z});
        const double along_m = std::abs(p.x() - 5.0 * std::round(p.x() / 5.0)) - 0.2;
        const double pillar_m = std::hypot(std::max(0.0, along_m), std::max(0.0, p.y() - 2.0));
        const double wall_m = std::min(p.y(), 2.4 - p.y());
        const double distance_m =
            std::min({p.z(), wall_m, pillar_m > 0.0 ? pillar_m : std::max(along_m, 2.0 - p.y())});
        if (distance_m < -0.3) continue;
        auto& block = volume.allocateBlock(mapping::TsdfVolume::computeBlockIndex({x, y, z}));
        auto& voxel = block.voxels[static_cast<std::size_t>(mapping::TsdfBlock::computeLinearIndex(
            mapping::TsdfVolume::computeLocalIndex({x, y, z})))];
        voxel.distance_m = static_cast<float>(std::min(distance_m, 0.3));
        voxel.weight = 1.0F;
      }
    }
  }
  return volume;
}

/// What a frame with a pose 5 km off sees: a copy of these blocks.
std::vector<GridIndex> addFarBlocks(const std::vector<GridIndex>& blocks,
                                    mapping::TsdfVolume& volume) {
  const GridIndex shift(0, 6250, 0);  // 5 km
  std::vector<GridIndex> far;
  for (const GridIndex& block : blocks) {
    const auto voxels = volume.findBlock(block)->voxels;
    volume.allocateBlock(block + shift).voxels = voxels;
    far.push_back(block + shift);
  }
  return far;
}

/// Voxels of the last 8 m move by a few millimetres in every update, as noise moves them. With
/// `far` a twelfth of the blocks lies 5 km off as well.
void updateWindowOfCorridor(benchmark::State& state) {
  const auto length_m = static_cast<int>(state.range(0));
  mapping::TsdfVolume volume = makeCorridor(length_m);
  std::vector<GridIndex> window;
  for (const GridIndex& block : volume.sortedBlockIndices()) {
    if (0.8 * (block.x() + 1) > length_m - 8.0) window.push_back(block);
  }
  const bool is_far = state.range(1) != 0;
  const auto twelfth = static_cast<std::ptrdiff_t>(window.size() / 12);
  const std::vector<GridIndex> far =
      is_far ? addFarBlocks({window.begin(), window.begin() + twelfth}, volume)
             : std::vector<GridIndex>{};
  PlaceExtractor extractor{PlacesConfig{}};
  for (int i = 0; i < 10 * length_m; ++i) {
    CameraPose pose{Stamp{1000000000LL + i * 100000000LL}, Pose::Identity()};
    pose.T_world_camera.translation() = Eigen::Vector3d(0.1 * i, 1.0, 1.4);
    extractor.addPose(pose);
  }
  extractor.update(volume, volume.sortedBlockIndices(), Stamp{1});
  std::mt19937 random(1);
  std::uniform_real_distribution<float> noise_m(-0.005F, 0.005F);
  for (auto _ : state) {
    state.PauseTiming();
    for (const GridIndex& block : window) {
      for (auto& voxel : volume.findBlock(block)->voxels) voxel.distance_m += noise_m(random);
    }
    std::vector<GridIndex> changed = window;
    changed.insert(changed.end(), far.begin(), far.end());
    state.ResumeTiming();
    extractor.update(volume, changed, Stamp{2});
  }
  state.counters["places"] = static_cast<double>(extractor.graph().places.size());
}
BENCHMARK(updateWindowOfCorridor)
    ->ArgNames({"length_m", "far"})
    ->Args({50, 0})
    ->Args({50, 1})
    ->Args({200, 0})
    ->Args({1000, 0})
    ->Unit(benchmark::kMillisecond);

#if __GLIBC_PREREQ(2, 33)  // mallinfo2
/// Heap of all that is kept of a walked corridor, without embeddings.
void memoryOfCorridor(benchmark::State& state) {
  const mapping::TsdfVolume volume = makeCorridor(static_cast<int>(state.range(0)));
  std::size_t num_places = 0;
  double bytes = 0.0;
  for (auto _ : state) {
    const std::size_t before = mallinfo2().uordblks;
    PlaceExtractor extractor{PlacesConfig{}};
    extractor.update(volume, volume.sortedBlockIndices(), Stamp{1});
    bytes = static_cast<double>(mallinfo2().uordblks - before);
    num_places = extractor.graph().places.size();
  }
  state.counters["places"] = static_cast<double>(num_places);
  state.counters["kB_per_place"] = 1e-3 * bytes / static_cast<double>(num_places);
  state.counters["kB_per_m"] = 1e-3 * bytes / static_cast<double>(state.range(0));
}
BENCHMARK(memoryOfCorridor)->ArgName("length_m")->Arg(200)->Unit(benchmark::kMillisecond);
#endif

void computeAllOfCorridor(benchmark::State& state) {
  const mapping::TsdfVolume volume = makeCorridor(static_cast<int>(state.range(0)));
  const auto blocks = volume.sortedBlockIndices();
  for (auto _ : state) {
    PlaceExtractor extractor{PlacesConfig{}};
    extractor.update(volume, blocks, Stamp{1});
  }
}
BENCHMARK(computeAllOfCorridor)
    ->ArgName("length_m")
    ->Arg(50)
    ->Arg(200)
    ->Unit(benchmark::kMillisecond);

void addView(benchmark::State& state) {
  const auto volume = makeBuilding(4);
  PlaceExtractor extractor{PlacesConfig{}};
  extractor.update(volume, volume.sortedBlockIndices(), Stamp{1});
  RgbdFrame frame;
  frame.camera = {640, 480, 525.0, 525.0, 319.5, 239.5};
  frame.depth.image = cv::Mat(480, 640, CV_16UC1, cv::Scalar(2500));
  const Embedding embedding = Embedding::Ones(768);
  for (auto _ : state) extractor.addView(frame, embedding);
}
BENCHMARK(addView)->Unit(benchmark::kMillisecond);

/// 5 % of a grid of 60 x 60 x 24 cells are sources.
struct Sources {
  GridExtent extent{{0, 0, 0}, {60, 60, 24}};
  std::vector<char> is_source;

  Sources() : is_source(extent.numCells()) {
    std::mt19937 random(1);
    std::bernoulli_distribution chosen(0.05);
    for (char& source : is_source) source = chosen(random) ? 1 : 0;
  }
};

void distanceTransform(benchmark::State& state) {
  const Sources sources;
  for (auto _ : state) {
    benchmark::DoNotOptimize(computeNearestField(sources.extent, sources.is_source, 30.0));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(sources.is_source.size()));
}
BENCHMARK(distanceTransform)->Unit(benchmark::kMillisecond);

void exhaustiveSearch(benchmark::State& state) {
  const Sources sources;
  std::vector<GridIndex> positions;
  for (std::size_t cell = 0; cell < sources.is_source.size(); ++cell) {
    if (sources.is_source[cell] != 0) positions.push_back(sources.extent.toIndex(cell));
  }
  for (auto _ : state) {
    int sum = 0;
    for (std::size_t cell = 0; cell < sources.is_source.size(); cell += 100) {
      const GridIndex at = sources.extent.toIndex(cell);
      int nearest = std::numeric_limits<int>::max();
      for (const GridIndex& p : positions) nearest = std::min(nearest, (p - at).squaredNorm());
      sum += nearest;
    }
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations() *
                          static_cast<int64_t>(sources.is_source.size() / 100));
}
BENCHMARK(exhaustiveSearch)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tsg::places

BENCHMARK_MAIN();
