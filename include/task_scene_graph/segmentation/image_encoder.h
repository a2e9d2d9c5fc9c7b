// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/segmentation/clip_tower.h"
#include "task_scene_graph/segmentation/inference_engine.h"
#include "task_scene_graph/segmentation/model_set.h"

namespace tsg::segmentation {

/// How a crop becomes a square.
enum class CropFit {
  kCenterCrop,  ///< shorter side to the square's, ends of the longer one cut off (CLIP's own way)
  kSquash,      ///< both sides to the square's, changes the aspect ratio
  kPad,         ///< longer side to the square's, black beside it
};

struct ImageEncoderConfig {
  CropFit fit = CropFit::kCenterCrop;
  int max_batch = 4;
  bool pad_batches = false;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.choice("fit", self.fit,
             config::Choices<CropFit>{{"center_crop", CropFit::kCenterCrop},
                                      {"squash", CropFit::kSquash},
                                      {"pad", CropFit::kPad}},
             "how a crop becomes square: center_crop cuts long objects' ends off, squash keeps all "
             "but changes the aspect ratio, pad adds black");
    v.field("max_batch", self.max_batch, {1, 256}, "",
            "most crops in one run of the encoder; batches have this many or a power of two less");
    v.field("pad_batches", self.pad_batches, {}, "",
            "fill the last batch up to the next size (GPU) instead of splitting it (CPU)");
  }
};

/// A part of an image to be embedded.
struct CropRequest {
  cv::Rect box_px;
  std::uint16_t keep_label = 0;  ///< if not 0, pixels with another label become black
};

/// Size of one encoder run: `used` crops in a tensor for `size`.
struct Batch {
  int size = 0;
  int used = 0;
};

/// Splits n crops into runs of few different sizes: max_batch and powers of two below it.
/// `pad`: at most the last run is not full. Otherwise all runs are full. Sum of `used` = n.
std::vector<Batch> planBatches(int num_crops, int max_batch, bool pad);

/// A crop as an 8-bit square of `size_px`, same channel order as the image. `box_px` must lie in
/// it.
cv::Mat cropToSquare(const cv::Mat& image, const cv::Mat& labels, const CropRequest& request,
                     CropFit fit, int size_px);

/// A CLIP-shaped image encoder: float32 [N, 3, S, S] -> [N, D]; ClipTower tells which files serve.
/// Thread safety: `encode` may run in several threads at once; `cancel` from any thread.
class ImageEncoder {
 public:
  /// Loads the file and runs it on a test pattern, at every batch size if it is not on the CPU.
  /// @throws InferenceError if the file cannot be used, or its embeddings have not the model set's
  /// size or are not finite.
  ImageEncoder(const ModelSet& models, const EngineConfig& engine,
               const ImageEncoderConfig& config);

  int inputSize() const { return tower_.inputSize(); }
  int embeddingSize() const { return tower_.embeddingSize(); }

  /// One row per request, as the network writes them (CLIP: not of unit length).
  /// @param labels the image's label image; needed only if a request keeps a label.
  /// @throws std::invalid_argument if a box is empty or not inside the image; Cancelled;
  /// InferenceError.
  EmbeddingMatrix encode(const ColorImage& color, const cv::Mat& labels,
                         const std::vector<CropRequest>& requests) const;

  void cancel() { tower_.cancel(); }

 private:
  void warmUp(bool all_sizes);
  void writeTensor(const cv::Mat& square, ColorOrder order, float* tensor) const;
  std::vector<float> makePattern(int batch_size) const;
  std::vector<float> makeTensor(const ColorImage& color, const cv::Mat& labels,
                                const CropRequest* requests, const Batch& batch) const;
  TensorView toView(const std::vector<float>& tensor, int batch_size) const;
  std::vector<Batch> plan(int num_crops) const;

  ClipTower tower_;
  ImageEncoderConfig config_;
  int threads_across_batches_ = 1;  ///< CPU: several runs at once
  int threads_within_batch_ = 1;    ///< GPU: one run at once, crops prepared by several threads
  std::array<std::array<float, 256>, 3> normalised_;  ///< RGB channel, 8-bit value -> input value
};

}  // namespace tsg::segmentation
