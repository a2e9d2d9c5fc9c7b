// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/segmenter_layout.h"

#include <algorithm>
#include <cmath>

namespace tsg::segmentation {
namespace {

constexpr std::int64_t kNumBoxValues = 4;
constexpr std::int64_t kNumPixelAnchors = 64;  // fewer say nothing about what boxes mean
constexpr const char* kExport =
    "export FastSAM, or another YOLOv8 or YOLO11 segmentation network, with scripts/export_models";

/// Whether a head of YOLO's gives so many candidates for an input of S x S pixels: `per_cell` for
/// each cell of grids with cells of 8, 16 and 32 px, and of 4 or 64 px in some.
bool isAnchorCount(std::int64_t count, std::int64_t input_size_px, std::int64_t per_cell) {
  const auto countCells = [&](std::int64_t cell_px) {
    const std::int64_t side = input_size_px / cell_px;
    return per_cell * side * side;
  };
  const std::int64_t usual = countCells(8) + countCells(16) + countCells(32);
  const std::int64_t others = count - usual;
  return usual > 0 && (others == 0 || others == countCells(4) || others == countCells(64) ||
                       others == countCells(4) + countCells(64));
}

/// The two sizes of predictions [1, rows, columns], and what they have to fit.
struct Sizes {
  std::int64_t rows = 0;
  std::int64_t columns = 0;
  std::int64_t prototypes = 0;
  std::int64_t input_size_px = 0;

  bool fitsRows(std::int64_t others) const { return rows >= kNumBoxValues + others + prototypes; }
  bool isAnchors(std::int64_t count, std::int64_t per_cell) const {
    return isAnchorCount(count, input_size_px, per_cell);
  }
};

/// FastSAM's own layout, [1, 4 + C + K, A].
bool areAnchorsLast(const Sizes& sizes) {
  if (sizes.columns <= 0 || !sizes.fitsRows(1)) return false;
  if (sizes.isAnchors(sizes.columns, 1)) return true;
  // Not a number that tells: the other way round must not be possible.
  return sizes.columns < kNumBoxValues + 1 + sizes.prototypes || sizes.rows < sizes.columns;
}

/// The same with rows and columns exchanged; of one class, for with more a column of YOLOX's
/// objectness would look like a class.
bool areAnchorsFirst(const Sizes& sizes) {
  return sizes.isAnchors(sizes.rows, 1) && sizes.columns == kNumBoxValues + 1 + sizes.prototypes;
}

std::string explainPredictions(const Sizes& sizes) {
  const std::string weights = std::to_string(sizes.prototypes) + " mask coefficients";
  if (sizes.isAnchors(sizes.rows, 3) && sizes.columns >= 6 + sizes.prototypes) {
    return "which looks like YOLOv5 or YOLOv7 (a row for each candidate, with a column of "
           "objectness)";
  }
  if (sizes.columns == 6 + sizes.prototypes) {
    return "which looks like an export with NMS inside (box, score, class, " + weights +
           "); export with nms=False, of YOLO26 and YOLOv10 also with end2end=False";
  }
  if (sizes.isAnchors(sizes.rows, 1) && sizes.columns > kNumBoxValues + 1 + sizes.prototypes) {
    return "which has rows and columns exchanged and more than one class or a column of "
           "objectness; expected [1,4+classes+" +
           std::to_string(sizes.prototypes) + ",candidates]";
  }
  if (sizes.rows == kNumBoxValues + sizes.prototypes) {
    return "which leaves no row for a score beside box and " + weights;
  }
  return "which is neither [1,4+classes+" + std::to_string(sizes.prototypes) +
         ",candidates] nor a layout that is known";
}

/// Index of the only float output of a rank; `none` or `several` else.
constexpr std::size_t kNone = static_cast<std::size_t>(-1);
constexpr std::size_t kSeveral = static_cast<std::size_t>(-2);

std::size_t findRank(const std::vector<TensorInfo>& infos, const std::vector<TensorView>& outputs,
                     std::size_t rank) {
  std::size_t found = kNone;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    if (outputs[i].shape.size() != rank || !isFloat(infos[i])) continue;
    if (found != kNone) return kSeveral;
    found = i;
  }
  return found;
}

std::string explainPrototypes(const std::string& name, const std::vector<std::int64_t>& shape) {
  const std::string found = name + " is " + toText(shape);
  if (shape[0] != 1) return found + ", of more than one image; export for one (batch=1)";
  if (shape[1] == shape[2] && shape[3] < shape[1]) {
    return found + ", which looks like mask prototypes with channels last; expected [1,K,P,P]";
  }
  if (shape[2] != shape[3]) return found + ", expected mask prototypes on a square grid, [1,K,P,P]";
  return shape[1] > 0 && shape[2] > 0 ? "" : found + ", which is empty";
}

std::string explainMissing(const std::vector<TensorInfo>& infos,
                           const std::vector<TensorView>& outputs, std::size_t predictions) {
  if (predictions != kNone && predictions != kSeveral) {
    const std::string found = infos[predictions].name + " is " + toText(outputs[predictions].shape);
    return "there are no mask prototypes ([1,K,P,P]) beside it: " + found +
           ", a network that finds boxes only";
  }
  return "expected one output [1,4+classes+K,candidates] and one [1,K,P,P]";
}

std::string explainScores(const float* scores, std::size_t count) {
  float least = 0.0F;
  float greatest = 0.0F;
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(scores[i])) return "a score is not finite; are its weights whole?";
    least = std::min(least, scores[i]);
    greatest = std::max(greatest, scores[i]);
  }
  constexpr float kRounding = 1e-2F;  // of half floats
  if (least >= -kRounding && greatest <= 1.0F + kRounding) return "";
  return "its scores run from " + std::to_string(least) + " to " + std::to_string(greatest) +
         ", expected 0 to 1 (the sigmoid belongs inside the network)";
}

std::string explainBoxes(const RawDetections& raw) {
  const std::size_t anchors = raw.num_anchors;
  const float* values = raw.predictions;
  if (!std::all_of(values, values + 4 * anchors,
                   [](float value) { return std::isfinite(value); })) {
    return "a box is not finite; are its weights whole?";
  }
  if (anchors < static_cast<std::size_t>(kNumPixelAnchors)) return "";
  // Candidates lie all over the image.
  const float farthest = *std::max_element(values, values + 2 * anchors);
  if (farthest <= 2.0F) {
    return "its boxes reach " + std::to_string(farthest) +
           ", expected pixels of the input; are they in shares of the image?";
  }
  for (std::size_t a = 0; a < anchors; ++a) {
    if (values[2 * anchors + a] < values[a] || values[3 * anchors + a] < values[anchors + a]) {
      return "";
    }
  }
  return "its boxes look like two corners, expected centre, width and height";
}

std::string explainValues(const RawDetections& raw) {
  const float* scores = raw.predictions + 4 * raw.num_anchors;
  const std::string scores_why =
      explainScores(scores, static_cast<std::size_t>(raw.num_classes) * raw.num_anchors);
  if (!scores_why.empty()) return scores_why;
  const std::string boxes_why = explainBoxes(raw);
  if (!boxes_why.empty()) return boxes_why;
  const float* weights = scores + static_cast<std::size_t>(raw.num_classes) * raw.num_anchors;
  const float* end =
      raw.predictions +
      (4 + static_cast<std::size_t>(raw.num_classes + raw.num_prototypes)) * raw.num_anchors;
  const auto is_finite = [](float value) { return std::isfinite(value); };
  const auto side = static_cast<std::size_t>(raw.prototype_size_px);
  const float* prototypes_end =
      raw.prototypes + static_cast<std::size_t>(raw.num_prototypes) * side * side;
  if (std::all_of(weights, end, is_finite) &&
      std::all_of(raw.prototypes, prototypes_end, is_finite)) {
    return "";
  }
  return "a mask value is not finite; are its weights whole?";
}

/// [1, A, R] as [1, R, A].
std::shared_ptr<const std::vector<float>> transpose(const TensorView& view) {
  const auto rows = static_cast<std::size_t>(view.shape[1]);
  const auto columns = static_cast<std::size_t>(view.shape[2]);
  const auto transposed = std::make_shared<std::vector<float>>(rows * columns);
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t c = 0; c < columns; ++c) {
      (*transposed)[c * rows + r] = view.values[r * columns + c];
    }
  }
  return transposed;
}

}  // namespace

std::string explainSegmenterInputs(const std::vector<TensorInfo>& inputs) {
  if (inputs.size() != 1 || inputs[0].shape.size() != 4)
    return "it takes something else than one image; export FastSAM";
  const auto& shape = inputs[0].shape;
  const bool may_be_channels = shape[1] == 3 || shape[1] < 0;
  if (!may_be_channels && shape[3] == 3) {
    return "it takes images with channels last; export it with channels first, [1,3,S,S]";
  }
  if (!may_be_channels) {
    return "it takes images of " + std::to_string(shape[1]) +
           " channels; export it for red, green, blue";
  }
  if (!isFloat(inputs[0])) {
    return "it takes pixels as " + inputs[0].element_type +
           "; export it without the preprocessing inside, for float32 images in 0..1";
  }
  if (shape[0] > 1) {
    return "it takes " + std::to_string(shape[0]) + " images at once; export it for one (batch=1)";
  }
  if (shape[2] > 0 && shape[3] > 0 && shape[2] != shape[3]) {
    return "it takes images of " + std::to_string(shape[3]) + "x" + std::to_string(shape[2]) +
           " px; export it for square ones (imgsz=640)";
  }
  return "";
}

SegmenterLayout findSegmenterLayout(const std::vector<TensorInfo>& infos,
                                    const std::vector<TensorView>& outputs, int input_size_px,
                                    const std::string& model) {
  const auto refuse = [&](const std::string& why) {
    throw InferenceError("segmenter '" + model + "' gives " + toText(infos, outputs) + ": " + why +
                         "; " + kExport);
  };
  SegmenterLayout layout{findRank(infos, outputs, 3), findRank(infos, outputs, 4), false};
  const bool are_found = std::max(layout.predictions, layout.prototypes) < outputs.size();
  if (!are_found) refuse(explainMissing(infos, outputs, layout.predictions));
  const auto& shape = outputs[layout.predictions].shape;
  const auto& grid = outputs[layout.prototypes].shape;
  const std::string grid_why = explainPrototypes(infos[layout.prototypes].name, grid);
  if (!grid_why.empty()) refuse(grid_why);
  const std::string found = infos[layout.predictions].name + " is " + toText(shape);
  if (shape[0] != 1) refuse(found + ", of more than one image");
  const Sizes sizes{shape[1], shape[2], grid[1], input_size_px};
  layout.are_anchors_first = areAnchorsFirst(sizes);
  if (!layout.are_anchors_first && !areAnchorsLast(sizes)) {
    refuse(found + ", " + explainPredictions(sizes));
  }
  const std::string values_why = explainValues(interpretOutputs(outputs, layout, model));
  if (!values_why.empty()) refuse(values_why);
  return layout;
}

RawDetections interpretOutputs(const std::vector<TensorView>& outputs,
                               const SegmenterLayout& layout, const std::string& model) {
  const TensorView& predictions = outputs.at(layout.predictions);
  const TensorView& prototypes = outputs.at(layout.prototypes);
  const std::size_t rows = layout.are_anchors_first ? 2 : 1;
  const auto& shape = predictions.shape;
  const auto& grid = prototypes.shape;
  const bool fits = shape.size() == 3 && grid.size() == 4 && shape[0] == 1 && grid[0] == 1 &&
                    grid[1] > 0 && shape[rows] >= kNumBoxValues + 1 + grid[1] &&
                    grid[2] == grid[3] && grid[2] > 0;
  if (!fits) {
    throw InferenceError("segmenter '" + model + "' gave outputs " + toText(shape) + " and " +
                         toText(grid) + ", expected FastSAM's [1,4+classes+K,A] and [1,K,P,P]");
  }
  RawDetections raw;
  raw.predictions = predictions.values;
  raw.prototypes = prototypes.values;
  raw.num_anchors = static_cast<std::size_t>(shape[3 - rows]);
  raw.num_prototypes = static_cast<int>(grid[1]);
  raw.num_classes = static_cast<int>(shape[rows] - kNumBoxValues - grid[1]);
  raw.prototype_size_px = static_cast<int>(grid[2]);
  if (layout.are_anchors_first) {
    const auto transposed = transpose(predictions);
    raw.predictions = transposed->data();
    raw.owner = transposed;
  }
  return raw;
}

}  // namespace tsg::segmentation
