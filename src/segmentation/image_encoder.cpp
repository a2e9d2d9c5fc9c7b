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

int chooseSize(std::int64_t from_file, int from_models) {
  return from_file > 0 ? static_cast<int>(from_file) : from_models;
}

}  // namespace

ImageEncoder::ImageEncoder(const ModelSet& models, const EngineConfig& engine,
                           const ImageEncoderConfig& config)
    : network_(models.image_encoder, makeRunConfig(engine)),
      config_(config),
      threads_across_batches_(resolveNumThreads(engine)),
      normalised_(makeTable(models)) {
  checkSignature();
  const std::vector<std::int64_t>& shape = network_.inputs()[0].shape;
  input_size_px_ = chooseSize(shape[2], models.image_encoder_input_size_px);
  fixed_batch_ = chooseSize(shape[0], 0);
  embedding_size_ = models.embedding_size;
  const bool on_cpu = engine.provider == ExecutionProvider::kCpu;
  if (!on_cpu) std::swap(threads_across_batches_, threads_within_batch_);
  warmUp(!on_cpu);
}

void ImageEncoder::checkSignature() const {
  const auto& inputs = network_.inputs();
  const auto& outputs = network_.outputs();
  const bool valid = inputs.size() == 1 && isFloat(inputs[0]) && inputs[0].shape.size() == 4 &&
                     inputs[0].shape[1] == 3 && inputs[0].shape[2] == inputs[0].shape[3] &&
                     !outputs.empty() && isFloat(outputs[0]);
  if (valid) return;
  throw InferenceError("image encoder '" + network_.path() + "' has inputs " + toText(inputs) +
                       " and outputs " + toText(outputs) +
                       ", expected CLIP's float32[N,3,S,S] -> float32[N,D]");
}

std::vector<Batch> ImageEncoder::plan(int num_crops) const {
  if (fixed_batch_ == 0) return planBatches(num_crops, config_.max_batch, config_.pad_batches);
  std::vector<Batch> batches;
  for (int left = num_crops; left > 0; left -= fixed_batch_) {
    batches.push_back({fixed_batch_, std::min(fixed_batch_, left)});
  }
  return batches;
}

void ImageEncoder::warmUp(bool all_sizes) {
  const auto values = 3 * static_cast<std::size_t>(input_size_px_ * input_size_px_);
  const int largest = all_sizes ? config_.max_batch : 1;
  for (int size = 1; size <= largest; size *= 2) {
    for (const Batch& batch : plan(size)) {
      runBatch(std::vector<float>(values * static_cast<std::size_t>(batch.size)), batch);
    }
  }
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

EmbeddingMatrix ImageEncoder::runBatch(const std::vector<float>& tensor, const Batch& batch) const {
  const std::vector<std::int64_t> shape = {batch.size, 3, input_size_px_, input_size_px_};
  const TensorView output = network_.run({shape, tensor.data(), nullptr}).front();
  if (output.shape != std::vector<std::int64_t>{batch.size, embedding_size_}) {
    throw InferenceError(
        "image encoder '" + network_.path() + "' gave " + toText(output.shape) + " for " +
        std::to_string(batch.size) + " crops, expected " + toText({batch.size, embedding_size_}) +
        " (the model set's embedding_size is " + std::to_string(embedding_size_) + ")");
  }
  return Eigen::Map<const EmbeddingMatrix>(output.values, batch.size, embedding_size_)
      .topRows(batch.used);
}

std::vector<float> ImageEncoder::makeTensor(const ColorImage& color, const cv::Mat& labels,
                                            const CropRequest* requests, const Batch& batch) const {
  const auto values = 3 * static_cast<std::size_t>(input_size_px_ * input_size_px_);
  std::vector<float> tensor(values * static_cast<std::size_t>(batch.size), 0.0F);
  const auto used = static_cast<std::size_t>(batch.used);
  runOnOwnThreads(used, threads_within_batch_, [&](std::size_t i) {
    const cv::Mat square =
        cropToSquare(color.image, labels, requests[i], config_.fit, input_size_px_);
    writeTensor(square, color.order, tensor.data() + i * values);
  });
  return tensor;
}

EmbeddingMatrix ImageEncoder::encode(const ColorImage& color, const cv::Mat& labels,
                                     const std::vector<CropRequest>& requests) const {
  EmbeddingMatrix embeddings(static_cast<Eigen::Index>(requests.size()), embedding_size_);
  const std::vector<Batch> batches = plan(static_cast<int>(requests.size()));
  std::vector<int> first(batches.size(), 0);
  for (std::size_t b = 1; b < batches.size(); ++b) first[b] = first[b - 1] + batches[b - 1].used;
  runOnOwnThreads(batches.size(), threads_across_batches_, [&](std::size_t b) {
    const auto tensor = makeTensor(color, labels, requests.data() + first[b], batches[b]);
    embeddings.middleRows(first[b], batches[b].used) = runBatch(tensor, batches[b]);
  });
  return embeddings;
}

}  // namespace tsg::segmentation
