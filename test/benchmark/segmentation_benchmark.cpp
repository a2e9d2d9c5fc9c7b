// SPDX-License-Identifier: BSD-3-Clause
// ms per 640x480 image of everything around the networks, at FastSAM's sizes ([1,37,8400] and
// [1,32,160,160], S = 640, crops of 224 px), beside the plain way (whole-image masks) and OpenCV's
// resize; then the networks themselves with the optional test models. One thread unless said.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "segmentation/resampling.h"
#include "support.h"
#include "task_scene_graph/segmentation/label_painter.h"
#include "task_scene_graph/segmentation/letterbox.h"
#include "task_scene_graph/segmentation/mask_decoder.h"
#include "task_scene_graph/segmentation/segmenter.h"

namespace tsg::segmentation {
namespace {

constexpr int kInput = 640;
constexpr int kGrid = 160;
constexpr int kPrototypes = 32;
constexpr std::size_t kAnchors = 8400;

cv::Mat makeImage() {
  cv::Mat image(480, 640, CV_8UC3);
  cv::RNG random(1);
  random.fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

/// Outputs as FastSAM gives them: smooth prototypes, `objects` boxes of 20 to 200 px, each found by
/// ten anchors.
class FakeOutputs {
 public:
  explicit FakeOutputs(int objects)
      : predictions_(37 * kAnchors), prototypes_(kPrototypes * kCells) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> unit(0.0F, 1.0F);
    std::normal_distribution<float> normal;
    for (int k = 0; k < kPrototypes; ++k) {
      const float fx = 0.2F * normal(random);
      const float fy = 0.2F * normal(random);
      for (int i = 0; i < kCells; ++i) {
        prototypes_[static_cast<std::size_t>(k * kCells + i)] =
            std::sin(fx * static_cast<float>(i % kGrid) + fy * static_cast<float>(i / kGrid));
      }
    }
    for (int object = 0; object < objects; ++object) {
      const float box[4] = {640.0F * unit(random), 80.0F + 480.0F * unit(random),
                            20.0F + 180.0F * unit(random), 20.0F + 180.0F * unit(random)};
      for (std::size_t copy = 0; copy < 10; ++copy) {
        const std::size_t anchor = static_cast<std::size_t>(object) * 10 + copy;
        for (std::size_t row = 0; row < 4; ++row) set(row, anchor, box[row] + normal(random));
        set(4, anchor, 0.6F + 0.4F * unit(random));
        for (std::size_t row = 5; row < 37; ++row) set(row, anchor, normal(random));
      }
    }
  }

  RawDetections raw() const {
    return {predictions_.data(), prototypes_.data(), kAnchors, 1, kPrototypes, kGrid, nullptr};
  }

 private:
  static constexpr int kCells = kGrid * kGrid;
  void set(std::size_t row, std::size_t anchor, float value) {
    predictions_[row * kAnchors + anchor] = value;
  }

  std::vector<float> predictions_;
  std::vector<float> prototypes_;
};

std::vector<SegmentMask> decodeAll(const RawDetections& raw,
                                   const std::vector<Detection>& detections) {
  const Letterbox letterbox = computeLetterbox({640, 480}, kInput);
  std::vector<SegmentMask> masks;
  for (const Detection& detection : detections) {
    masks.push_back(decodeMask(raw, detection, letterbox));
  }
  return masks;
}

void fillLetterbox(benchmark::State& state) {
  const ColorImage color{{}, makeImage(), ColorOrder::kBgr, nullptr};
  const Letterbox letterbox = computeLetterbox(color.image.size(), kInput);
  std::vector<float> tensor(3 * kInput * kInput);
  for (auto _ : state) {
    fillLetterboxTensor(color, letterbox, tensor.data());
    benchmark::DoNotOptimize(tensor.data());
  }
}
BENCHMARK(fillLetterbox)->Unit(benchmark::kMillisecond);

void selectDetections(benchmark::State& state) {
  const FakeOutputs outputs(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    const auto kept = suppressOverlaps(findCandidates(outputs.raw(), 0.55), 0.85, 300);
    state.counters["kept"] = static_cast<double>(kept.size());
  }
}
BENCHMARK(selectDetections)->Arg(60)->Arg(180)->Unit(benchmark::kMillisecond);

std::vector<Detection> selectAll(const FakeOutputs& outputs) {
  return suppressOverlaps(findCandidates(outputs.raw(), 0.55), 0.85, 300);
}

void decodeMasksInsideBoxes(benchmark::State& state) {
  const FakeOutputs outputs(static_cast<int>(state.range(0)));
  const auto detections = selectAll(outputs);
  for (auto _ : state) benchmark::DoNotOptimize(decodeAll(outputs.raw(), detections).data());
  state.counters["masks"] = static_cast<double>(detections.size());
}
BENCHMARK(decodeMasksInsideBoxes)->Arg(60)->Arg(180)->Unit(benchmark::kMillisecond);

/// The plain way: one matrix product for all cells, every mask enlarged whole, then cut.
void decodeWholeMasks(benchmark::State& state) {
  const FakeOutputs outputs(static_cast<int>(state.range(0)));
  const auto detections = selectAll(outputs);
  const RawDetections raw = outputs.raw();
  const Eigen::Map<const EmbeddingMatrix> prototypes(raw.prototypes, kPrototypes, kGrid * kGrid);
  const Eigen::Map<const EmbeddingMatrix> rows(raw.predictions, 37, kAnchors);
  for (auto _ : state) {
    EmbeddingMatrix weights(detections.size(), kPrototypes);
    for (std::size_t i = 0; i < detections.size(); ++i) {
      weights.row(static_cast<Eigen::Index>(i)) =
          rows.col(static_cast<Eigen::Index>(detections[i].anchor)).tail(kPrototypes).transpose();
    }
    EmbeddingMatrix logits = weights * prototypes;
    for (std::size_t i = 0; i < detections.size(); ++i) {
      const cv::Mat grid(kGrid, kGrid, CV_32FC1, logits.row(static_cast<Eigen::Index>(i)).data());
      cv::Mat large;
      cv::resize(grid(cv::Rect(0, 20, 160, 120)), large, {640, 480});
      const cv::Mat mask = large > 0.0;
      benchmark::DoNotOptimize(mask.data);
    }
  }
}
BENCHMARK(decodeWholeMasks)->Arg(60)->Arg(180)->Unit(benchmark::kMillisecond);

void paintAndRefine(benchmark::State& state) {
  const FakeOutputs outputs(static_cast<int>(state.range(0)));
  const auto masks = decodeAll(outputs.raw(), selectAll(outputs));
  for (auto _ : state) {
    const auto segments = paintLabels(masks, {640, 480}, true, 20);
    state.counters["segments"] = static_cast<double>(segments.scores.size());
  }
}
BENCHMARK(paintAndRefine)->Arg(60)->Arg(180)->Unit(benchmark::kMillisecond);

void prepareCrop(benchmark::State& state) {
  const cv::Mat image = makeImage();
  const cv::Mat labels(480, 640, CV_16UC1, cv::Scalar(1));
  const int side = static_cast<int>(state.range(0));
  const CropRequest request{{20, 30, side, side * 3 / 4}, 1};
  for (auto _ : state) {
    const cv::Mat square = cropToSquare(image, labels, request, CropFit::kCenterCrop, 224);
    benchmark::DoNotOptimize(square.data);
  }
}
BENCHMARK(prepareCrop)->Arg(60)->Arg(200)->Arg(600)->Unit(benchmark::kMillisecond);

/// OpenCV's resize of the same crop, which does not antialias.
void resizeCropWithOpenCv(benchmark::State& state) {
  const int side = static_cast<int>(state.range(0));
  const cv::Mat crop = makeImage()(cv::Rect(20, 30, side, side * 3 / 4));
  for (auto _ : state) {
    cv::Mat square;
    cv::resize(crop, square, {224, 224}, 0, 0, cv::INTER_CUBIC);
    benchmark::DoNotOptimize(square.data);
  }
}
BENCHMARK(resizeCropWithOpenCv)->Arg(60)->Arg(200)->Arg(600)->Unit(benchmark::kMillisecond);

/// The optional test models and one photograph; null, with the reason in `state`, without them.
struct RealModels {
  ModelSet models;
  ColorImage color;
};

std::optional<RealModels> loadRealModels(benchmark::State& state) {
  const char* given = std::getenv("TSG_BENCHMARK_MODELS");
  const auto shared = test::findSharedFolder();
  const std::string models =
      given != nullptr ? given : (shared ? (*shared / "models/models.yaml").string() : "");
  if (!std::filesystem::exists(models)) {
    state.SkipWithError("no models (set TSG_BENCHMARK_MODELS to a model set, or TSG_SHARED)");
    return std::nullopt;
  }
  cv::Mat image;
  if (shared) image = cv::imread((*shared / "data/kitchen/frame-000000.color.jpg").string());
  return RealModels{loadModelSet(models),
                    {{}, image.empty() ? makeImage() : image, ColorOrder::kBgr, nullptr}};
}

/// Time that passed, on the clock and on the processor (all threads of this process).
class Cost {
 public:
  template <typename Action>
  void add(Action&& action) {
    const auto wall = std::chrono::steady_clock::now();
    const std::clock_t cpu = std::clock();
    action();
    cpu_ms_ += 1e3 * static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
    wall_ms_ +=
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - wall).count();
    ++times_;
  }
  double cpuMs() const { return cpu_ms_ / times_; }
  double wallMs() const { return wall_ms_ / times_; }

 private:
  double cpu_ms_ = 0.0;
  double wall_ms_ = 0.0;
  int times_ = 0;
};

EngineConfig withThreads(benchmark::State& state) {
  EngineConfig engine;
  engine.num_threads = static_cast<int>(state.range(0));
  return engine;
}

void runSegmenterNetwork(benchmark::State& state) {
  const auto real = loadRealModels(state);
  if (!real) return;
  const Network network(real->models.segmenter, withThreads(state));
  const std::vector<float> tensor(3 * kInput * kInput, 0.4F);
  for (auto _ : state) network.run({{1, 3, kInput, kInput}, tensor.data(), nullptr});
}
BENCHMARK(runSegmenterNetwork)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

void prepareCrops(const cv::Mat& image, const LabelledSegments& segments, int size_px) {
  for (std::size_t i = 0; i < segments.boxes_px.size(); ++i) {
    for (const std::uint16_t label : {std::uint16_t{0}, static_cast<std::uint16_t>(i + 1)}) {
      const cv::Mat square = cropToSquare(image, segments.labels, {segments.boxes_px[i], label},
                                          CropFit::kCenterCrop, size_px);
      benchmark::DoNotOptimize(square.data);
    }
  }
}

/// The bar: CPU time of all around the networks, at 60 segments, as a share of the segmenting
/// network's own, measured in turn; crops apart, once for all segments and once for the fifth of
/// them that schedule/mode reuse embeds.
void compareAroundTheNetworks(benchmark::State& state) {
  const auto real = loadRealModels(state);
  if (!real) return;
  const Network network(real->models.segmenter, withThreads(state));
  const FakeOutputs outputs(60);
  const Letterbox letterbox = computeLetterbox({640, 480}, kInput);
  std::vector<float> tensor(3 * kInput * kInput);
  Cost alone;
  Cost around;
  Cost crops;
  for (auto _ : state) {
    LabelledSegments segments;
    around.add([&] {
      fillLetterboxTensor(real->color, letterbox, tensor.data());
      segments = paintLabels(decodeAll(outputs.raw(), selectAll(outputs)), {640, 480}, true, 20);
    });
    crops.add([&] { prepareCrops(real->color.image, segments, 224); });
    alone.add([&] { network.run({{1, 3, kInput, kInput}, tensor.data(), nullptr}); });
  }
  state.counters["network_ms"] = alone.cpuMs();
  state.counters["around_%"] = 100.0 * around.cpuMs() / alone.cpuMs();
  state.counters["crops_%"] = 100.0 * crops.cpuMs() / alone.cpuMs();
  state.counters["around+crops/5_%"] =
      100.0 * (around.cpuMs() + 0.2 * crops.cpuMs()) / alone.cpuMs();
}
BENCHMARK(compareAroundTheNetworks)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

constexpr int kCrops = 16;

/// The bare engine on ready tensors of four crops.
void runEncoderNetwork(benchmark::State& state) {
  const auto real = loadRealModels(state);
  if (!real) return;
  const Network network(real->models.image_encoder, withThreads(state));
  const std::vector<float> tensor(4 * 3 * 224 * 224, 0.4F);
  for (auto _ : state) {
    for (int i = 0; i < kCrops; i += 4) network.run({{4, 3, 224, 224}, tensor.data(), nullptr});
  }
  state.counters["crops/s"] =
      benchmark::Counter(kCrops, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(runEncoderNetwork)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

/// The same number of crops cut out of an image, prepared and embedded.
void encodeCrops(benchmark::State& state) {
  const auto real = loadRealModels(state);
  if (!real) return;
  const ImageEncoder encoder(real->models, withThreads(state), {});
  std::vector<CropRequest> requests;
  for (int i = 0; i < kCrops; ++i)
    requests.push_back({{10 * i, 8 * i, 60 + 15 * i, 50 + 20 * i}, 0});
  for (auto _ : state) benchmark::DoNotOptimize(encoder.encode(real->color, {}, requests).data());
  state.counters["crops/s"] =
      benchmark::Counter(kCrops, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(encodeCrops)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

/// The bar: crops per second through our path, as a share of the bare engine's on ready tensors of
/// four, measured in turn.
void compareEncoderPaths(benchmark::State& state) {
  const auto real = loadRealModels(state);
  if (!real) return;
  const Network network(real->models.image_encoder, withThreads(state));
  const ImageEncoder encoder(real->models, withThreads(state), {});
  const int side = encoder.inputSize();
  const std::vector<float> tensor(static_cast<std::size_t>(4 * 3 * side * side), 0.4F);
  std::vector<CropRequest> requests;
  for (int i = 0; i < kCrops; ++i)
    requests.push_back({{10 * i, 8 * i, 60 + 15 * i, 50 + 20 * i}, 0});
  Cost bare;
  Cost ours;
  for (auto _ : state) {
    bare.add([&] {
      for (int i = 0; i < kCrops; i += 4) network.run({{4, 3, side, side}, tensor.data(), nullptr});
    });
    ours.add([&] { encoder.encode(real->color, {}, requests); });
  }
  state.counters["bare_ms/crop"] = bare.wallMs() / kCrops;
  state.counters["throughput_%"] = 100.0 * bare.wallMs() / ours.wallMs();
  state.counters["throughput_cpu_%"] = 100.0 * bare.cpuMs() / ours.cpuMs();
}
BENCHMARK(compareEncoderPaths)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

/// The whole chain; segments/frame says how much there was to embed.
void segmentFrame(benchmark::State& state) {
  const auto real = loadRealModels(state);
  if (!real) return;
  SegmenterConfig config;
  config.engine = withThreads(state);
  Segmenter segmenter(real->models, config);
  for (auto _ : state) {
    const Segmentation segmentation = segmenter.segment(real->color);
    state.counters["segments"] = static_cast<double>(segmentation.numSegments());
  }
}
BENCHMARK(segmentFrame)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace tsg::segmentation

BENCHMARK_MAIN();
