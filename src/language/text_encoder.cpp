// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/language/text_encoder.h"

#include <algorithm>
#include <cmath>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/language/prompts.h"

namespace tsg::language {
namespace {

using segmentation::InferenceError;

const TextEncoderConfig& checked(const TextEncoderConfig& config) {
  config::validate(config, "text encoder");
  checkTemplates(config.prompt_templates);
  return config;
}

const segmentation::ModelSet& requireTextEncoder(const segmentation::ModelSet& models) {
  if (!models.text_encoder.empty()) return models;
  throw InferenceError(segmentation::describe(models) +
                       " has no text encoder (key 'text_encoder'); tasks must come with their "
                       "embeddings");
}

Vocabulary loadVocabulary(const segmentation::ModelSet& models) {
  if (!models.tokenizer.empty()) return Vocabulary::load(models.tokenizer);
  if (const auto installed = findInstalledVocabulary()) return Vocabulary::load(*installed);
  throw std::runtime_error(segmentation::describe(models) +
                           " names no vocabulary (key 'tokenizer') and CLIP's is not installed; "
                           "scripts/install_vocabulary gets it");
}

segmentation::TokenView toView(const TokenMatrix& tokens) {
  return {{tokens.rows(), tokens.cols()}, tokens.data()};
}

/// Filled up to `count` rows with copies of the last one.
TokenMatrix padRows(const TokenMatrix& tokens, Eigen::Index count) {
  TokenMatrix padded(count, tokens.cols());
  for (Eigen::Index i = 0; i < count; ++i)
    padded.row(i) = tokens.row(std::min(i, tokens.rows() - 1));
  return padded;
}

}  // namespace

TextEncoder::TextEncoder(const segmentation::ModelSet& models,
                         const segmentation::EngineConfig& engine, const TextEncoderConfig& config)
    : config_(checked(config)),
      tower_(segmentation::Modality::kText, requireTextEncoder(models), engine),
      tokenizer_(loadVocabulary(models), tower_.inputSize()) {
  probe();
}

void TextEncoder::probe() {
  const std::vector<std::string> texts = {"", "a red mug"};
  const TokenMatrix first = tokenizer_.tokenize({texts[0]});
  tower_.probe(toView(padRows(first, std::max(tower_.fixedBatch(), 1))));
  const EmbeddingMatrix both = encode(texts);
  if (!both.row(0).isApprox(both.row(1), 1e-6F)) return;
  throw InferenceError("text encoder '" + tower_.path() + "' gives the same for '' and '" +
                       texts[1] +
                       "', expected different embeddings; is its output the one at the "
                       "text's end?");
}

EmbeddingMatrix TextEncoder::encode(const std::vector<std::string>& utf8_texts) const {
  const EmbeddingMatrix embeddings = encodeUnscaled(utf8_texts);
  checkValues(embeddings, utf8_texts);
  return normalizeRows(embeddings);
}

EmbeddingMatrix TextEncoder::encodeUnscaled(const std::vector<std::string>& utf8_texts) const {
  const TokenMatrix tokens = tokenizer_.tokenize(utf8_texts);
  const Eigen::Index batch = tower_.fixedBatch() > 0 ? tower_.fixedBatch() : config_.max_batch;
  EmbeddingMatrix embeddings(tokens.rows(), embeddingSize());
  for (Eigen::Index begin = 0; begin < tokens.rows(); begin += batch) {
    const Eigen::Index count = std::min(batch, tokens.rows() - begin);
    const Eigen::Index rows = tower_.fixedBatch() > 0 ? batch : count;
    const TokenMatrix part = padRows(tokens.middleRows(begin, count), rows);
    embeddings.middleRows(begin, count) = tower_.run(toView(part)).topRows(count);
  }
  return embeddings;
}

EmbeddingMatrix TextEncoder::encodeTasks(const std::vector<std::string>& names) const {
  const auto& templates = config_.prompt_templates;
  return averageGroups(encode(fillTemplates(names, templates)), static_cast<int>(templates.size()));
}

void TextEncoder::checkValues(const EmbeddingMatrix& embeddings,
                              const std::vector<std::string>& utf8_texts) const {
  for (Eigen::Index i = 0; i < embeddings.rows(); ++i) {
    const float norm = embeddings.row(i).norm();
    if (std::isfinite(norm) && norm > 0.0F) continue;
    throw InferenceError("text encoder '" + tower_.path() + "' gives for '" +
                         utf8_texts[static_cast<std::size_t>(i)] + "' a vector of length " +
                         std::to_string(norm) + ", expected a finite one above 0");
  }
}

}  // namespace tsg::language
