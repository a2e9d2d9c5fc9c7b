// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/segmentation/embedding_schedule.h"
#include "task_scene_graph/segmentation/image_encoder.h"
#include "task_scene_graph/segmentation/inference_engine.h"
#include "task_scene_graph/segmentation/model_set.h"

namespace tsg::segmentation {

struct SegmenterConfig {
  double score_threshold = -1.0;
  double iou_threshold = -1.0;
  int max_segments = 300;
  int min_area_px = 20;
  bool refine_masks = true;
  bool embed_crop = true;
  bool embed_masked_crop = true;
  bool embed_image = true;
  int crop_padding_px = 4;
  ScheduleConfig schedule;
  ImageEncoderConfig encoder;
  EngineConfig engine;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("score_threshold", self.score_threshold, {-1.0, 1.0}, "",
            "masks that do not exceed this score are dropped; negative: the model set's value");
    v.field("iou_threshold", self.iou_threshold, {-1.0, 1.0}, "",
            "of two boxes whose IoU exceeds this, the better one stays; negative: the model set's");
    v.field("max_segments", self.max_segments, {1, 65535}, "", "most segments of one image");
    v.field("min_area_px", self.min_area_px, {0, 1e9}, "px", "smaller segments are dropped");
    v.field("refine_masks", self.refine_masks, {}, "",
            "3x3 erosion, then dilation: thin bridges and specks go");
    v.field("embed_crop", self.embed_crop, {}, "", "embed the padded box around each segment");
    v.field("embed_masked_crop", self.embed_masked_crop, {}, "",
            "embed the same box with the background black; with embed_crop: the mean of both");
    v.field("embed_image", self.embed_image, {}, "", "embed the whole image (for places)");
    v.field("crop_padding_px", self.crop_padding_px, {0, 4096}, "px",
            "margin around a segment's box");
    v.group("schedule", self.schedule);
    v.group("encoder", self.encoder);
    v.group("engine", self.engine);
  }
};

/// What was done so far, and what went wrong without stopping anything.
struct SegmenterCounters {
  std::uint64_t images = 0;
  std::uint64_t images_without_segments = 0;
  std::uint64_t embeddings_not_finite = 0;  ///< left as zeros: "not embedded"
  std::uint64_t crops_embedded = 0;         ///< whole images among them
  std::uint64_t images_carried = 0;         ///< the segmenting network skipped them
  std::uint64_t segments_reused = 0;        ///< kept the embedding of an earlier image
  std::uint64_t segments_dropped = 0;       ///< over the schedule's budget and without an embedding
};

/// Cuts a colour image into segments and embeds each of them and the whole image
/// [Clio24, Sec. IV-A].
///
/// Of a segment, two crops are embedded: its box with a margin, and the same with everything but
/// the segment black; the mean of both, scaled to unit length, is the segment's embedding.
/// deviation: the paper's program does not scale it; cosines are the same, and means over frames
/// then weigh all frames alike. It also keeps segments of any size; here `min_area_px` applies.
///
/// With schedule/mode `reuse`, see EmbeddingSchedule; results then depend on the images before.
///
/// Thread safety: `segment` and `counters` belong to one thread; `embed` and `cancel` may come from
/// any. The result does not depend on the number of threads.
class Segmenter {
 public:
  /// Loads both networks and runs each once, so that the first image is not slower.
  /// @throws InferenceError (library, provider, a file, its shapes), config::ConfigError.
  Segmenter(const ModelSet& models, const SegmenterConfig& config);
  ~Segmenter();

  /// Segments are numbered by falling score. An image in which nothing is found gives 0 x D
  /// embeddings and an empty label image of its size.
  /// @throws std::invalid_argument if the image is empty or not CV_8UC3; Cancelled; InferenceError.
  Segmentation segment(const ColorImage& color);

  /// A whole image, embedded as the boxes around segments are: size D, of length 1. For pictures of
  /// what is looked for. From any thread, also while `segment` runs.
  /// @throws std::invalid_argument if the image is empty or not CV_8UC3; Cancelled; InferenceError,
  /// also where this segmenter embeds nothing.
  Embedding embed(const ColorImage& color) const;

  /// Ends a running `segment` within milliseconds; it and all later ones throw Cancelled.
  void cancel();

  const SegmenterCounters& counters() const;
  /// D, the length of every embedding.
  int embeddingSize() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace tsg::segmentation
