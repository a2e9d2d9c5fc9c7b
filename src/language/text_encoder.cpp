// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/language/text_encoder.h"

#include <algorithm>
#include <cmath>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/language/prompts.h"

namespace tsg::language {
namespace {

using segmentation::InferenceError;
using segmentation::TensorView;

constexpr int kInt32 = 32;
constexpr int kInt64 = 64;

/// Bits of the network's tokens, 0 if it takes something else.
int tokenBits(const segmentation::TensorInfo& input) {
  if (input.element_type == "int64") return kInt64;
  return input.element_type == "int32" ? kInt32 : 0;
}

const TextEncoderConfig& checked(const TextEncoderConfig& config) {
  config::validate(config, "text encoder");
  checkTemplates(config.prompt_templates);
  return config;
}

const std::string& requirePath(const segmentation::ModelSet& models) {
  if (!models.text_encoder.empty()) return models.text_encoder;
  throw InferenceError("model set '" + models.name +
                       "' has no text encoder (key 'text_encoder'); tasks must come with their "
                       "embeddings");
}

Vocabulary loadVocabulary(const segmentation::ModelSet& models) {
  if (!models.tokenizer.empty()) return Vocabulary::load(models.tokenizer);
  if (const auto installed = findInstalledVocabulary()) return Vocabulary::load(*installed);
  throw std::runtime_error("model set '" + models.name +
                           "' names no vocabulary (key 'tokenizer') and CLIP's is not installed; "
                           "scripts/install_vocabulary gets it");
}

int contextLength(const segmentation::Network& network) {
  const auto& inputs = network.inputs();
  const bool is_given = !inputs.empty() && inputs[0].shape.size() == 2 && inputs[0].shape[1] > 0;
  return is_given ? static_cast<int>(inputs[0].shape[1]) : kClipContextLength;
}

}  // namespace

TextEncoder::TextEncoder(const segmentation::ModelSet& models,
                         const segmentation::EngineConfig& engine, const TextEncoderConfig& config)
    : config_(checked(config)),
      network_(requirePath(models), engine),
      tokenizer_(loadVocabulary(models), contextLength(network_)),
      models_name_(models.name),
      embedding_size_(models.embedding_size) {
  checkSignature();
  fixed_batch_ = static_cast<int>(std::max<std::int64_t>(network_.inputs()[0].shape[0], 0));
  encode({""});  // finds out the embeddings' size, which files leave open
}

void TextEncoder::checkSignature() const {
  const auto& inputs = network_.inputs();
  const auto& outputs = network_.outputs();
  const bool valid = inputs.size() == 1 && tokenBits(inputs[0]) != 0 &&
                     inputs[0].shape.size() == 2 && !outputs.empty() &&
                     segmentation::isFloat(outputs[0]);
  if (valid) return;
  throw InferenceError("text encoder '" + network_.path() + "' has inputs " +
                       segmentation::toText(inputs) + " and outputs " +
                       segmentation::toText(outputs) +
                       ", expected CLIP's int64[N,77] or int32[N,77] -> float32[N,D]");
}

EmbeddingMatrix TextEncoder::encode(const std::vector<std::string>& utf8_texts) const {
  const TokenMatrix tokens = tokenizer_.tokenize(utf8_texts);
  const Eigen::Index batch = fixed_batch_ > 0 ? fixed_batch_ : config_.max_batch;
  EmbeddingMatrix embeddings(tokens.rows(), embedding_size_);
  for (Eigen::Index begin = 0; begin < tokens.rows(); begin += batch) {
    const Eigen::Index count = std::min(batch, tokens.rows() - begin);
    TokenMatrix part = tokens.middleRows(begin, count);
    if (fixed_batch_ > 0) {
      part.conservativeResize(batch, Eigen::NoChange);
      part.bottomRows(batch - count).setZero();
    }
    embeddings.middleRows(begin, count) = runBatch(part).topRows(count);
  }
  checkValues(embeddings, utf8_texts);
  return normalizeRows(std::move(embeddings));
}

EmbeddingMatrix TextEncoder::encodeTasks(const std::vector<std::string>& names) const {
  const auto& templates = config_.prompt_templates;
  return averageGroups(encode(fillTemplates(names, templates)), static_cast<int>(templates.size()));
}

EmbeddingMatrix TextEncoder::runBatch(const TokenMatrix& tokens) const {
  const std::vector<std::int64_t> shape = {tokens.rows(), tokens.cols()};
  if (tokenBits(network_.inputs()[0]) == kInt64) {
    const segmentation::IntegerTensorView<std::int64_t> view{shape, tokens.data()};
    return toEmbeddings(network_.run(view)[0], tokens.rows());
  }
  const std::vector<std::int32_t> narrow(tokens.data(), tokens.data() + tokens.size());
  const segmentation::IntegerTensorView<std::int32_t> view{shape, narrow.data()};
  return toEmbeddings(network_.run(view)[0], tokens.rows());
}

EmbeddingMatrix TextEncoder::toEmbeddings(const TensorView& output, Eigen::Index count) const {
  if (output.shape.size() != 2 || output.shape[0] != count) {
    throw InferenceError("text encoder '" + network_.path() + "' gives " +
                         segmentation::toText(output.shape) + " for " + std::to_string(count) +
                         " texts, expected [" + std::to_string(count) + ",D]");
  }
  if (output.shape[1] != embedding_size_) {
    throw InferenceError("text encoder '" + network_.path() + "' gives embeddings of " +
                         std::to_string(output.shape[1]) + " values, but model set '" +
                         models_name_ + "' says embedding_size " + std::to_string(embedding_size_));
  }
  return Eigen::Map<const EmbeddingMatrix>(output.values, count, embedding_size_);
}

void TextEncoder::checkValues(const EmbeddingMatrix& embeddings,
                              const std::vector<std::string>& utf8_texts) const {
  for (Eigen::Index i = 0; i < embeddings.rows(); ++i) {
    const float norm = embeddings.row(i).norm();
    if (std::isfinite(norm) && norm > 0.0F) continue;
    throw InferenceError("text encoder '" + network_.path() + "' gives for '" +
                         utf8_texts[static_cast<std::size_t>(i)] + "' a vector of length " +
                         std::to_string(norm) + ", expected a finite one above 0");
  }
}

}  // namespace tsg::language
