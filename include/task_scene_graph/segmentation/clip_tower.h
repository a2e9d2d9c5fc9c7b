// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "task_scene_graph/core/embedding.h"
#include "task_scene_graph/segmentation/clip_signature.h"
#include "task_scene_graph/segmentation/inference_engine.h"
#include "task_scene_graph/segmentation/model_set.h"

namespace tsg::segmentation {

using TokenView = IntegerTensorView<std::int64_t>;

/// One of CLIP's two encoders in an ONNX file: float32 [N, 3, S, S] (images), or int64 or int32
/// [N, L] (tokens), to float32 [N, D].
///
/// A text encoder may ask for an attention mask, too. A file may hold both encoders (Hugging Face's
/// `model.onnx`); the one that is not wanted reads a black image or a text of two tokens.
///
/// Thread safety: all but `probe` may be called from several threads at once.
class ClipTower {
 public:
  /// Loads the file and finds its inputs.
  /// @throws InferenceError naming the file, what was found and what was expected, with the usual
  /// cause, if the file is absent, no network, or has other inputs.
  ClipTower(Modality modality, const ModelSet& models, const EngineConfig& engine);

  const std::string& path() const { return network_.path(); }
  /// Side of the square images in pixels, or length of the texts in tokens: the file's, or the
  /// model set's where the file leaves it open.
  int inputSize() const { return input_size_; }
  /// The file's batch size, 0 where it leaves it open.
  int fixedBatch() const { return fixed_batch_; }
  int embeddingSize() const { return embedding_size_; }

  /// Finds the output that is the embedding by a run (see findEmbeddingOutput); comes before all
  /// others.
  /// @throws InferenceError if there is no such output, or a row of it is not finite or all zero.
  EmbeddingMatrix probe(const TensorView& images);
  EmbeddingMatrix probe(const TokenView& tokens);

  /// One row per image or text, as the network writes them.
  /// @param tokens each row's largest number marks its end, as in CLIP.
  /// @throws InferenceError if the network fails or the rows have another number or size;
  /// Cancelled.
  EmbeddingMatrix run(const TensorView& images) const;
  EmbeddingMatrix run(const TokenView& tokens) const;

  void cancel() { network_.cancel(); }

 private:
  [[noreturn]] void refuseInputs(const std::string& hint) const;
  void findSizes();
  void makeFillers(const ModelSet& models);
  std::vector<TensorView> runNetwork(const TensorView& images, const TokenView& tokens) const;
  /// `failure` says what a failure means.
  std::vector<TensorView> runFirst(const TensorView& images, const TokenView& tokens,
                                   const std::string& failure) const;
  EmbeddingMatrix chooseOutput(const std::vector<TensorView>& outputs, std::int64_t count);
  EmbeddingMatrix toRows(const TensorView& output, std::int64_t count) const;

  Modality modality_;
  std::string models_text_;
  std::string wanted_output_;
  int embedding_size_ = 0;
  int input_size_ = 0;  ///< the model set's until the file's is known
  int fixed_batch_ = 0;
  Network network_;
  std::vector<ClipInput> roles_;  ///< of the inputs
  std::size_t output_ = 0;
  std::vector<float> black_;  ///< what the encoder that is not wanted reads
  std::vector<std::int64_t> two_tokens_;
  TensorView filler_images_;
  TokenView filler_tokens_;
};

}  // namespace tsg::segmentation
