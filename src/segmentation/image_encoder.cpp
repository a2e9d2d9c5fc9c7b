// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/image_encoder.h"

#include <algorithm>

#include "own_threads.h"

namespace tsg::segmentation {
namespace {

using Table = std::array<std::array<float, 256>, 3>;

Table makeTable(const ModelSet& models) {
  Table table{};
  for (std::size_t c = 0; c < 3; ++c) {
    const auto mean = static_cast<float>(models.image_mean.at(c));
    const auto deviation = static_cast<float>(models.image_std.at(c));
    for (std::size_t value = 0; value < 256; ++value) {
      table[c][value] = (static_cast<float>(value) / 255.0F - mean) / deviation;
    }
  }
  return table;
}

/// On the CPU, several runs of one thread each go on at once: as fast as one run of several
/// threads, and the result does not depend on their number (ONNX Runtime's own threads change sums
/// slightly).
EngineConfig makeRunConfig(EngineConfig engine) {
  if (engine.provider == ExecutionProvider::kCpu) engine.num_threads = 1;
  return engine;
}

}  // namespace

ImageEncoder::ImageEncoder(const ModelSet& models, const EngineConfig& engine,
                           const ImageEncoderConfig& config)
    : tower_(Modality::kImage, models, makeRunConfig(engine)),
      config_(config),
      threads_across_batches_(resolveNumThreads(engine)),
      normalised_(makeTable(models)) {
  const bool on_cpu = engine.provider == ExecutionProvider::kCpu;
  if (!on_cpu) std::swap(threads_across_batches_, threads_within_batch_);
  warmUp(!on_cpu);
}

std::vector<Batch> ImageEncoder::plan(int num_crops) const {
  const int fixed_batch = tower_.fixedBatch();
  if (fixed_batch == 0) return planBatches(num_crops, config_.max_batch, config_.pad_batches);
  std::vector<Batch> batches;
  for (int left = num_crops; left > 0; left -= fixed_batch) {
    batches.push_back({fixed_batch, std::min(fixed_batch, left)});
  }
  return batches;
}

void ImageEncoder::warmUp(bool all_sizes) {
  const int first = plan(1).front().size;
  tower_.probe(toView(makePattern(first), first));
  const int largest = all_sizes ? config_.max_batch : 1;
  for (int size = 2; size <= largest; size *= 2) {
    for (const Batch& batch : plan(size)) tower_.run(toView(makePattern(batch.size), batch.size));
  }
}

/// Waves of grey: a constant image could divide by 0 in networks that normalise by themselves.
std::vector<float> ImageEncoder::makePattern(int batch_size) const {
  const auto side = static_cast<std::size_t>(inputSize());
  std::vector<float> tensor(3 * side * side * static_cast<std::size_t>(batch_size));
  for (std::size_t i = 0; i < tensor.size(); ++i) {
    const std::size_t value = 7 * (i % side) + 13 * (i / side % side);
    tensor[i] = normalised_[i / (side * side) % 3][value % 128];
  }
  return tensor;
}

TensorView ImageEncoder::toView(const std::vector<float>& tensor, int batch_size) const {
  return {{batch_size, 3, inputSize(), inputSize()}, tensor.data(), nullptr};
}

void ImageEncoder::writeTensor(const cv::Mat& square, ColorOrder order, float* tensor) const {
  const std::size_t plane = square.total();
  const std::size_t red = order == ColorOrder::kRgb ? 0 : 2;
  const std::uint8_t* pixel = square.ptr<std::uint8_t>();  // a fresh image has no gaps
  for (std::size_t i = 0; i < plane; ++i, pixel += 3) {
    tensor[i] = normalised_[0][pixel[red]];
    tensor[i + plane] = normalised_[1][pixel[1]];
    tensor[i + 2 * plane] = normalised_[2][pixel[2 - red]];
  }
}

std::vector<float> ImageEncoder::makeTensor(const ColorImage& color, const cv::Mat& labels,
                                            const CropRequest* requests, const Batch& batch) const {
  const auto values = 3 * static_cast<std::size_t>(inputSize() * inputSize());
  std::vector<float> tensor(values * static_cast<std::size_t>(batch.size), 0.0F);
  const auto used = static_cast<std::size_t>(batch.used);
  runOnOwnThreads(used, threads_within_batch_, [&](std::size_t i) {
    const cv::Mat square = cropToSquare(color.image, labels, requests[i], config_.fit, inputSize());
    writeTensor(square, color.order, tensor.data() + i * values);
  });
  return tensor;
}

EmbeddingMatrix ImageEncoder::encode(const ColorImage& color, const cv::Mat& labels,
                                     const std::vector<CropRequest>& requests) const {
  EmbeddingMatrix embeddings(static_cast<Eigen::Index>(requests.size()), embeddingSize());
  const std::vector<Batch> batches = plan(static_cast<int>(requests.size()));
  std::vector<int> first(batches.size(), 0);
  for (std::size_t b = 1; b < batches.size(); ++b) first[b] = first[b - 1] + batches[b - 1].used;
  runOnOwnThreads(batches.size(), threads_across_batches_, [&](std::size_t b) {
    const auto tensor = makeTensor(color, labels, requests.data() + first[b], batches[b]);
    embeddings.middleRows(first[b], batches[b].used) =
        tower_.run(toView(tensor, batches[b].size)).topRows(batches[b].used);
  });
  return embeddings;
}

}  // namespace tsg::segmentation
