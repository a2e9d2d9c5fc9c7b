// SPDX-License-Identifier: BSD-3-Clause
// ms per frame of 640x480 with 30 segments and D = 768, for 10 to 1000 live tracks; beside it the
// search for candidates alone, with the prefilter and without.
#include <benchmark/benchmark.h>

#include <random>

#include "task_scene_graph/tracking/tracker.h"

namespace tsg::tracking {
namespace {

constexpr int kSegments = 30;
constexpr int kEmbeddingSize = 768;

Embedding makeRandomEmbedding(std::mt19937& random) {
  std::normal_distribution<float> normal;
  Embedding embedding(kEmbeddingSize);
  for (int i = 0; i < kEmbeddingSize; ++i) embedding(i) = normal(random);
  return embedding.normalized();
}

/// A bumpy slanted wall 1.5 to 3 m away.
RgbdFrame makeFrame(double x_m, double stamp_s) {
  RgbdFrame frame;
  frame.stamp = Stamp::fromSeconds(stamp_s);
  frame.camera = {640, 480, 525.0, 525.0, 319.5, 239.5};
  frame.T_world_camera.translation().x() = x_m;
  frame.depth.image = cv::Mat(480, 640, CV_16UC1);
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      const int depth_mm = 1500 + 2 * u + 17 * ((u / 20 + v / 20) % 5);
      frame.depth.image.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(depth_mm);
    }
  }
  return frame;
}

/// 6 x 5 tiles that cover the image.
Segmentation makeSegmentation(Stamp stamp, std::mt19937& random) {
  Segmentation segmentation;
  segmentation.stamp = stamp;
  segmentation.labels = cv::Mat::zeros(480, 640, CV_16UC1);
  segmentation.embeddings.resize(kSegments, kEmbeddingSize);
  segmentation.confidences.assign(kSegments, 1.0F);
  for (int s = 0; s < kSegments; ++s) {
    segmentation.labels(cv::Rect(106 * (s % 6), 96 * (s / 6), 106, 96)).setTo(s + 1);
    segmentation.embeddings.row(s) = makeRandomEmbedding(random).transpose();
  }
  return segmentation;
}

/// Leaves only the first `used` segments.
Segmentation keepFirst(const Segmentation& all, int used) {
  Segmentation kept = all;
  kept.labels = all.labels.clone();
  kept.labels.setTo(0, all.labels > used);
  return kept;
}

/// A tracker that has walked along a wall and now stands still: `num_tracks` live tracks, of which
/// the last 30 (or fewer) are in view; the other segments in view are not labelled.
class Corridor {
 public:
  explicit Corridor(int num_tracks) : tracker_(makeConfig()) {
    std::mt19937 random(1);
    double x_m = 0.0;
    for (int left = num_tracks; left > 0; left -= kSegments, x_m += 0.2) {
      frame_ = makeFrame(x_m, 0.0);
      segmentation_ = keepFirst(makeSegmentation(frame_.stamp, random), left);
      advance();
    }
  }

  void advance() {
    frame_.stamp = segmentation_.stamp = Stamp{++stamp_ns_};
    tracker_.update(frame_, segmentation_);
  }

  std::size_t numLiveTracks() const { return tracker_.numLiveTracks(); }

 private:
  static TrackerConfig makeConfig() {
    TrackerConfig config;
    config.window_s = 600.0;
    return config;
  }

  Tracker tracker_;
  std::int64_t stamp_ns_ = 0;
  RgbdFrame frame_;
  Segmentation segmentation_;
};

void updateTracker(benchmark::State& state) {
  Corridor corridor(static_cast<int>(state.range(0)));
  for (auto _ : state) corridor.advance();
  state.counters["live_tracks"] = static_cast<double>(corridor.numLiveTracks());
}
BENCHMARK(updateTracker)->Arg(10)->Arg(100)->Arg(1000)->Unit(benchmark::kMillisecond);

/// The tracks of such a walk as bare voxel sets and means.
class Pairs {
 public:
  explicit Pairs(std::size_t num_tracks) {
    std::mt19937 random(1);
    for (double x_m = 0.0; tracks_.size() < num_tracks; x_m += 0.2) {
      const RgbdFrame frame = makeFrame(x_m, 1.0);
      const Segmentation segmentation = makeSegmentation(frame.stamp, random);
      segments_ = computeSegmentPoints(frame, segmentation.labels, kSegments, {0.1, 5.0});
      embeddings_ = segmentation.embeddings;
      for (std::size_t s = 0; s < segments_.size() && tracks_.size() < num_tracks; ++s) {
        tracks_.push_back(segments_[s].voxels);
        means_.emplace_back(embeddings_.row(static_cast<Eigen::Index>(s)).transpose());
      }
    }
  }

  std::size_t countCandidates(bool use_prefilter) const {
    std::size_t count = 0;
    for (std::size_t s = 0; s < segments_.size(); ++s) {
      const auto embedding = embeddings_.row(static_cast<Eigen::Index>(s)).transpose();
      for (std::size_t t = 0; t < tracks_.size(); ++t) {
        if (use_prefilter && !mayReachIoU(segments_[s].voxels, tracks_[t], 0.6)) continue;
        if (computeCosine(embedding, means_[t]) < 0.9) continue;
        count += computeIoU(segments_[s].voxels, tracks_[t]) >= 0.6 ? 1U : 0U;
      }
    }
    return count;
  }

 private:
  std::vector<SegmentPoints> segments_;
  EmbeddingMatrix embeddings_;
  std::vector<VoxelSet> tracks_;
  std::vector<Embedding> means_;
};

void findCandidates(benchmark::State& state) {
  const Pairs pairs(static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(pairs.countCandidates(state.range(1) == 1));
  state.counters["candidates"] = static_cast<double>(pairs.countCandidates(state.range(1) == 1));
}
BENCHMARK(findCandidates)
    ->ArgNames({"tracks", "prefilter"})
    ->ArgsProduct({{10, 100, 1000}, {1, 0}})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tsg::tracking

BENCHMARK_MAIN();
