// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/language/word_encoder.h"

#include <stdexcept>

namespace tsg::language {

WordEncoder::WordEncoder(const std::string& models_path) : models_path_(models_path) {
  if (hasModels()) models_ = segmentation::loadModelSet(models_path);
}

EmbeddingMatrix WordEncoder::encode(const std::vector<std::string>& names) {
  if (!canEncode()) {
    const std::string what = hasModels()
                                 ? "model set '" + models_path_ + "' has no text_encoder"
                                 : std::string("there is no model set (parameter `models`)");
    throw std::runtime_error("words need a text encoder, and " + what +
                             "; give embeddings instead, see encode_tasks");
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (encoder_ == nullptr) {
      encoder_ = std::make_unique<TextEncoder>(models_, segmentation::EngineConfig{});
    }
  }
  return encoder_->encodeTasks(names);
}

}  // namespace tsg::language
