// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "task_scene_graph/segmentation/inference_engine.h"

namespace tsg::segmentation {

/// What one of CLIP's two encoders reads.
enum class Modality { kImage, kText };

/// What an input of a CLIP encoder takes.
enum class ClipInput { kImages, kTokens, kMask, kUnknown };

/// Of each input, by shape, type and name: images have four dimensions, tokens and masks are
/// integers of two.
std::vector<ClipInput> findClipInputs(const std::vector<TensorInfo>& inputs);

/// What is usually behind inputs that an encoder of this modality cannot have ("it takes images
/// with channels last; ..."), and what to do; "" if they are right.
std::string explainClipInputs(Modality modality, const std::vector<TensorInfo>& inputs);

/// What is looked for among the outputs of an encoder.
struct EmbeddingSearch {
  Modality modality = Modality::kImage;
  std::int64_t count = 1;   ///< images or texts of the run
  std::int64_t size = 0;    ///< the model set's embedding_size
  std::string wanted_name;  ///< the model set's choice, or empty
  std::string encoder;      ///< for messages: "image encoder 'a.onnx'"
  std::string models;       ///< for messages: "model set 'b' (b.yaml)"
};

/// Index of the output that holds one embedding per row.
///
/// The one that the model set names, else the one named `image_embeds` or `text_embeds`, else the
/// only one of shape [count, size] (dimensions of 1 do not matter) that its name does not give away
/// as something else. Hidden states and `pooler_output` are such: in CLIP they come before the
/// projection into the space that images and texts share, and may well have its size.
/// @throws InferenceError naming all outputs and what to do if there is none or more than one.
std::size_t findEmbeddingOutput(const std::vector<TensorInfo>& infos,
                                const std::vector<TensorView>& outputs,
                                const EmbeddingSearch& search);

/// Whether an output holds `count` rows of `size` values; dimensions of 1 do not matter.
bool isEmbeddingShaped(const TensorView& output, std::int64_t count, std::int64_t size);

}  // namespace tsg::segmentation
