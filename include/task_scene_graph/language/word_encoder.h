// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "task_scene_graph/core/embedding.h"
#include "task_scene_graph/language/text_encoder.h"
#include "task_scene_graph/segmentation/model_set.h"

namespace tsg::language {

/// The text encoder of a chain: loaded when words first need it, and kept. Thread-safe.
class WordEncoder {
 public:
  /// @param models_path  model set (YAML); empty: there is none, only ready embeddings will do
  /// @throws as segmentation::loadModelSet().
  explicit WordEncoder(const std::string& models_path);

  bool hasModels() const { return !models_path_.empty(); }
  /// Whether the model set has a text encoder.
  bool canEncode() const { return !models_.text_encoder.empty(); }
  /// Of the model set; 0 without one.
  int embeddingSize() const { return hasModels() ? models_.embedding_size : 0; }
  /// "" without a model set.
  const std::string& modelSetName() const { return models_.name; }

  /// One row of length 1 for each name, as TextEncoder::encodeTasks(). The first call loads the
  /// network. @throws std::runtime_error saying what is missing if there is no text encoder; as
  /// TextEncoder.
  EmbeddingMatrix encode(const std::vector<std::string>& names);

 private:
  std::string models_path_;
  segmentation::ModelSet models_;
  std::mutex mutex_;  ///< guards `encoder_` while it is loaded
  std::unique_ptr<TextEncoder> encoder_;
};

}  // namespace tsg::language
