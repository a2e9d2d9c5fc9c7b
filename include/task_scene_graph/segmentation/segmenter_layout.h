// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "task_scene_graph/segmentation/inference_engine.h"
#include "task_scene_graph/segmentation/mask_decoder.h"

namespace tsg::segmentation {

/// What the outputs of a segmentation network mean: FastSAM's (YOLOv8-seg, YOLO11-seg and others),
/// [1, 4 + C + K, A] and [1, K, P, P] in any order and beside outputs of other ranks. A network of
/// one class may also give [1, A, 5 + K].
struct SegmenterLayout {
  std::size_t predictions = 0;     ///< index of the output with boxes, scores, weights
  std::size_t prototypes = 1;      ///< index of the output with the mask prototypes
  bool are_anchors_first = false;  ///< predictions are [1, A, 5 + K]
};

/// What is usually behind inputs that FastSAM has not, and what to do; "" if they are right:
/// float32 or float16 [1, 3, S, S], where sizes may be open.
std::string explainSegmenterInputs(const std::vector<TensorInfo>& inputs);

/// Finds the layout in the outputs of a run on an image that is not one single colour.
/// @param input_size_px S.
/// @param model name for messages.
/// @throws InferenceError naming `model`, all outputs and what to do, for other layouts that are
/// known (with non-maximum suppression inside, YOLOv5's, without masks, ...) and for all unknown
/// ones; also if boxes are not in pixels or scores not in 0..1, or values are not finite.
SegmenterLayout findSegmenterLayout(const std::vector<TensorInfo>& infos,
                                    const std::vector<TensorView>& outputs, int input_size_px,
                                    const std::string& model);

/// Finds sizes in the outputs' shapes.
/// @throws InferenceError naming `model` and both shapes if they do not fit the layout.
RawDetections interpretOutputs(const std::vector<TensorView>& outputs,
                               const SegmenterLayout& layout, const std::string& model);

}  // namespace tsg::segmentation
