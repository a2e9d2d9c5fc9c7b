// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/core/embedding.h"
#include "task_scene_graph/language/tokenizer.h"
#include "task_scene_graph/segmentation/clip_tower.h"
#include "task_scene_graph/segmentation/inference_engine.h"
#include "task_scene_graph/segmentation/model_set.h"

namespace tsg::language {

struct TextEncoderConfig {
  std::vector<std::string> prompt_templates = {"{}"};
  int max_batch = 16;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("prompt_templates", self.prompt_templates, {}, "",
            "what a task becomes before it is embedded, {} standing for it; of several, the mean "
            "embedding is taken");
    v.field("max_batch", self.max_batch, {1, 1024}, "", "most prompts in one run of the encoder");
  }
};

/// Turns words into vectors of the space that the model set's image encoder maps images to: CLIP's
/// text encoder, int64 or int32 tokens [N, 77] -> float32 [N, D] (segmentation::ClipTower tells
/// which files serve).
/// Thread safety: all but the constructor may be called from several threads at once.
class TextEncoder {
 public:
  /// Loads the vocabulary (the model set's `tokenizer`, else the installed one) and the network,
  /// and runs it on two texts.
  /// @throws config::ConfigError, std::invalid_argument if the configuration is wrong;
  /// std::runtime_error naming the vocabulary file; segmentation::InferenceError naming the network
  /// file, if there is none, it has another shape, its embeddings have not the model set's size, or
  /// it gives the same for both texts.
  TextEncoder(const segmentation::ModelSet& models, const segmentation::EngineConfig& engine,
              const TextEncoderConfig& config = {});

  int embeddingSize() const { return tower_.embeddingSize(); }

  /// One row of length 1 per text, without templates.
  /// @throws std::invalid_argument if a text is not valid UTF-8; segmentation::Cancelled;
  /// segmentation::InferenceError if the network fails or its output is not finite or all zero.
  EmbeddingMatrix encode(const std::vector<std::string>& utf8_texts) const;

  /// One row of length 1 per task: each template filled with its name, encoded, and averaged.
  /// @throws as `encode`.
  EmbeddingMatrix encodeTasks(const std::vector<std::string>& names) const;

  /// Ends running calls soon; they and all later ones throw segmentation::Cancelled.
  void cancel() { tower_.cancel(); }

 private:
  void probe();
  EmbeddingMatrix encodeUnscaled(const std::vector<std::string>& utf8_texts) const;
  void checkValues(const EmbeddingMatrix& embeddings,
                   const std::vector<std::string>& utf8_texts) const;

  TextEncoderConfig config_;
  segmentation::ClipTower tower_;
  Tokenizer tokenizer_;
};

}  // namespace tsg::language
