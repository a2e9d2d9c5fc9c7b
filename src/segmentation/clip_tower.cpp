// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/clip_tower.h"

#include <algorithm>
#include <cmath>

namespace tsg::segmentation {
namespace {

const char* nameOf(Modality modality) {
  return modality == Modality::kImage ? "image encoder" : "text encoder";
}

std::size_t findRole(const std::vector<ClipInput>& roles, ClipInput role) {
  return static_cast<std::size_t>(std::find(roles.begin(), roles.end(), role) - roles.begin());
}

std::int64_t orElse(std::int64_t size, std::int64_t otherwise) {
  return size > 0 ? size : otherwise;
}

/// 1 for each token up to the text's end, the largest number, and 0 behind it.
std::vector<std::int64_t> makeMask(const TokenView& tokens) {
  const auto length = static_cast<std::size_t>(tokens.shape[1]);
  std::vector<std::int64_t> mask(static_cast<std::size_t>(tokens.shape[0]) * length, 0);
  for (std::size_t begin = 0; begin < mask.size(); begin += length) {
    const std::int64_t* row = tokens.values + begin;
    const auto end = std::max_element(row, row + length) - row;
    std::fill_n(mask.begin() + static_cast<std::ptrdiff_t>(begin), end + 1, 1);
  }
  return mask;
}

/// As the file wants its integers; `narrow` keeps what has to be converted.
InputTensor toInput(const TokenView& wide, const TensorInfo& info,
                    std::vector<std::int32_t>& narrow) {
  if (info.element_type == "int64") return wide;
  const auto count = static_cast<std::size_t>(wide.shape[0] * wide.shape[1]);
  narrow.resize(count);
  std::transform(wide.values, wide.values + count, narrow.begin(),
                 [](std::int64_t value) { return static_cast<std::int32_t>(value); });
  return IntegerTensorView<std::int32_t>{wide.shape, narrow.data()};
}

}  // namespace

ClipTower::ClipTower(Modality modality, const ModelSet& models, const EngineConfig& engine)
    : modality_(modality),
      models_text_(describe(models)),
      wanted_output_(modality == Modality::kImage ? models.image_encoder_output
                                                  : models.text_encoder_output),
      embedding_size_(models.embedding_size),
      input_size_(modality == Modality::kImage ? models.image_encoder_input_size_px
                                               : models.text_context_length),
      network_(modality == Modality::kImage ? models.image_encoder : models.text_encoder, engine),
      roles_(findClipInputs(network_.inputs())) {
  const std::string hint = explainClipInputs(modality, network_.inputs());
  if (!hint.empty()) refuseInputs(hint);
  findSizes();
  makeFillers(models);
}

void ClipTower::refuseInputs(const std::string& hint) const {
  const char* expected = modality_ == Modality::kImage
                             ? "CLIP's float32[N,3,S,S] -> float32[N,D]"
                             : "CLIP's int64[N,77] or int32[N,77] -> float32[N,D]";
  throw InferenceError(std::string(nameOf(modality_)) + " '" + path() + "' has inputs " +
                       toText(network_.inputs()) + " and outputs " + toText(network_.outputs()) +
                       ", expected " + expected + ": " + hint);
}

void ClipTower::findSizes() {
  const ClipInput role = modality_ == Modality::kImage ? ClipInput::kImages : ClipInput::kTokens;
  const auto& shape = network_.inputs()[findRole(roles_, role)].shape;
  fixed_batch_ = static_cast<int>(std::max<std::int64_t>(shape[0], 0));
  if (modality_ == Modality::kImage) {
    input_size_ = static_cast<int>(orElse(std::max(shape[2], shape[3]), input_size_));
  } else if (shape[1] > 0 && shape[1] != input_size_) {
    refuseInputs("it reads " + std::to_string(shape[1]) + " tokens, not " +
                 std::to_string(input_size_) +
                 ". SigLIP's text encoders read 64 of another vocabulary, to which CLIP's tokens "
                 "mean something else. If this one does read CLIP's tokens, say so in " +
                 models_text_ + ": 'text_context_length: " + std::to_string(shape[1]) + "'");
  }
}

void ClipTower::makeFillers(const ModelSet& models) {
  const std::size_t images = findRole(roles_, ClipInput::kImages);
  if (modality_ == Modality::kText && images < roles_.size()) {
    const auto& shape = network_.inputs()[images].shape;
    const std::int64_t side =
        orElse(std::max(shape[2], shape[3]), models.image_encoder_input_size_px);
    const std::int64_t batch = orElse(shape[0], 1);
    black_.assign(static_cast<std::size_t>(batch * 3 * side * side), 0.0F);
    filler_images_ = {{batch, 3, side, side}, black_.data(), nullptr};
  }
  const std::size_t tokens = findRole(roles_, ClipInput::kTokens);
  if (modality_ == Modality::kImage && tokens < roles_.size()) {
    const auto& shape = network_.inputs()[tokens].shape;
    const std::int64_t length = orElse(shape[1], 2);
    const std::int64_t batch = orElse(shape[0], 1);
    two_tokens_.assign(static_cast<std::size_t>(batch * length), 0);
    for (std::size_t i = 1; i < two_tokens_.size(); i += static_cast<std::size_t>(length)) {
      two_tokens_[i] = 1;
    }
    filler_tokens_ = {{batch, length}, two_tokens_.data()};
  }
}

std::vector<TensorView> ClipTower::runNetwork(const TensorView& images,
                                              const TokenView& tokens) const {
  const bool has_mask = findRole(roles_, ClipInput::kMask) < roles_.size();
  const std::vector<std::int64_t> mask = has_mask ? makeMask(tokens) : std::vector<std::int64_t>{};
  std::vector<std::vector<std::int32_t>> narrow(roles_.size());
  std::vector<InputTensor> inputs;
  for (std::size_t i = 0; i < roles_.size(); ++i) {
    const TensorInfo& info = network_.inputs()[i];
    if (roles_[i] == ClipInput::kImages) {
      inputs.emplace_back(images);
    } else {
      const TokenView mask_view{tokens.shape, mask.data()};
      inputs.push_back(
          toInput(roles_[i] == ClipInput::kMask ? mask_view : tokens, info, narrow[i]));
    }
  }
  return network_.run(inputs);
}

EmbeddingMatrix ClipTower::chooseOutput(const std::vector<TensorView>& outputs,
                                        std::int64_t count) {
  const std::string encoder = std::string(nameOf(modality_)) + " '" + path() + "'";
  output_ = findEmbeddingOutput(
      network_.outputs(), outputs,
      {modality_, count, embedding_size_, wanted_output_, encoder, models_text_});
  const EmbeddingMatrix rows = toRows(outputs[output_], count);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const float norm = rows.row(i).norm();
    if (std::isfinite(norm) && norm > 0.0F) continue;
    throw InferenceError(
        encoder + " gives a vector of length " + std::to_string(norm) +
        " at its first run, expected a finite one above 0; are its weights whole?");
  }
  return rows;
}

EmbeddingMatrix ClipTower::toRows(const TensorView& output, std::int64_t count) const {
  if (!isEmbeddingShaped(output, count, embedding_size_)) {
    throw InferenceError(std::string(nameOf(modality_)) + " '" + path() + "' gave " +
                         toText(output.shape) + " for " + std::to_string(count) + ", expected " +
                         toText({count, embedding_size_}));
  }
  return Eigen::Map<const EmbeddingMatrix>(output.values, static_cast<Eigen::Index>(count),
                                           embedding_size_);
}

EmbeddingMatrix ClipTower::probe(const TensorView& images) {
  const auto outputs =
      runFirst(images, filler_tokens_,
               "cannot take images of " + std::to_string(input_size_) +
                   " px (its own size, or image_encoder_input_size_px of " + models_text_ + ")");
  return chooseOutput(outputs, images.shape[0]);
}

EmbeddingMatrix ClipTower::probe(const TokenView& tokens) {
  const auto outputs = runFirst(filler_images_, tokens,
                                "cannot read " + std::to_string(tokens.shape[1]) +
                                    " tokens of CLIP's tokenizer, numbers up to 49407; is it "
                                    "another model's (SigLIP)?");
  return chooseOutput(outputs, tokens.shape[0]);
}

std::vector<TensorView> ClipTower::runFirst(const TensorView& images, const TokenView& tokens,
                                            const std::string& failure) const {
  try {
    return runNetwork(images, tokens);
  } catch (const InferenceError& e) {
    throw InferenceError(std::string(nameOf(modality_)) + " '" + path() + "' " + failure + ": " +
                         e.what());
  }
}

EmbeddingMatrix ClipTower::run(const TensorView& images) const {
  return toRows(runNetwork(images, filler_tokens_)[output_], images.shape[0]);
}

EmbeddingMatrix ClipTower::run(const TokenView& tokens) const {
  return toRows(runNetwork(filler_images_, tokens)[output_], tokens.shape[0]);
}

}  // namespace tsg::segmentation
