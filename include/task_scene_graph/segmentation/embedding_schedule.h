// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/core/embedding.h"
#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/segmentation/appearance.h"
#include "task_scene_graph/segmentation/image_motion.h"
#include "task_scene_graph/segmentation/label_painter.h"

namespace tsg::segmentation {

/// Which segments the image encoder sees.
enum class ScheduleMode {
  kExact,  ///< all of every image
  kReuse,  ///< those that are new, have changed, or were embedded long ago
};

struct ScheduleConfig {
  ScheduleMode mode = ScheduleMode::kExact;
  int max_crops_per_frame = 0;
  double max_ms_per_frame = 0.0;
  int max_skipped_images = 0;
  double min_known_share = 0.85;
  double max_age_s = 2.0;
  double max_gap_s = 1.0;
  double image_period_s = 0.5;
  double min_mask_iou = 0.5;
  double max_color_change_8bit = 12.0;
  double max_shift = 0.15;
  double min_overlap = 0.8;
  double min_view_gain = 1.2;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.choice("mode", self.mode,
             config::Choices<ScheduleMode>{{"exact", ScheduleMode::kExact},
                                           {"reuse", ScheduleMode::kReuse}},
             "exact: embed every segment of every image; reuse: a segment that continues one of "
             "the image before keeps its embedding. The other parameters here act in reuse only");
    v.field("max_crops_per_frame", self.max_crops_per_frame, {0, 1e6}, "",
            "most crops of segments that one image may cost (two per segment by default), but one "
            "segment at least; 0: no limit");
    v.field("max_ms_per_frame", self.max_ms_per_frame, {0.0, 1e6}, "ms",
            "the same as time: divided by what a crop took so far. Results then depend on how fast "
            "the machine is; 0: no limit");
    v.field("max_skipped_images", self.max_skipped_images, {0, 1000}, "",
            "the segmenting network may skip so many images in a row; in them, segments move with "
            "the image. 0: it sees every image");
    v.field("min_known_share", self.min_known_share, {0.0, 1.0}, "",
            "it skips none of which a smaller share was in view, and looked the same, when it last "
            "ran");
    v.field("max_age_s", self.max_age_s, {0.0, 1e6}, "s",
            "a segment that was last embedded longer ago is embedded again");
    v.field("max_gap_s", self.max_gap_s, {0.0, 1e6}, "s",
            "after a longer gap between two images, or a step back, nothing is reused");
    v.field("image_period_s", self.image_period_s, {0.0, 1e6}, "s",
            "the whole image is embedded when this has passed since it was last");
    v.field("min_mask_iou", self.min_mask_iou, {0.0, 1.0}, "",
            "a segment continues another if their masks, laid upon each other, have this IoU");
    v.field("max_color_change_8bit", self.max_color_change_8bit, {0.0, 255.0}, "",
            "a segment whose colours differ more from those it was embedded with has changed");
    v.field("max_shift", self.max_shift, {0.0, 2.0}, "",
            "a segment's centre moves at most so far between two images, in image widths");
    v.field("min_overlap", self.min_overlap, {0.0, 1.0}, "",
            "a segment also continues another of like colour if, moved with the image, they have "
            "this share of the smaller one in common (a thing that comes into view or is half "
            "hidden)");
    v.field("min_view_gain", self.min_view_gain, {1.0, 1e6}, "",
            "a segment is embedded again when its view is so much better (square root of the area, "
            "less at the image's border) than the best it was embedded in");
  }
};

/// Chooses which segments of an image need the image encoder, and carries the embeddings of the
/// others on from the image before.
///
/// A segment *continues* one of the image before if it lies near it and its mask, moved upon the
/// other, has `min_mask_iou`, or if it covers `min_overlap` of what that one became by the image's
/// motion and has its colour; pairs are made greedily, most similar first, each segment at most
/// once. What needs the encoder comes in this order: segments that continue none, changed ones
/// (their mean colour is no longer that which was embedded), those now seen better, old ones; among
/// equals the best view first (large, central, not cut off by the image's border). Those beyond the
/// budget carry on what they have; one that has nothing is dropped.
///
/// A carried embedding is the mean of a segment's embeddings since it last changed, weighted with
/// their views' quality and scaled to unit length.
///
/// deviation: the wish was to reuse the feature of the track that a segment continues (voxel IoU
/// and appearance unchanged). Tracks and voxels are known only two stages on, where depth and pose
/// have come in; to ask for them here would close a circle in the chain (the tracker itself
/// associates by these embeddings), make the segmenter wait for poses, and would not work on images
/// alone. At a camera's rate what continues a track mostly overlaps a segment of the image before,
/// and what does not is embedded.
///
/// The result depends on the images only, unless `max_ms_per_frame` is set. Thread safety: one
/// thread.
class EmbeddingSchedule {
 public:
  /// What is known of one segment.
  struct Memory {
    cv::Rect box_px;
    Appearance seen;               ///< in the newest image
    double quality_px = 0.0;       ///< of the view in the newest image
    Appearance embedded;           ///< when it was embedded
    double best_quality_px = 0.0;  ///< of the views that were embedded since the last change
    Stamp embedded_at;
    Embedding sum;  ///< of unit embeddings since the last change, weighted; empty = none yet
  };

  /// What to do with the segments of one image, by index.
  struct Plan {
    std::vector<std::size_t> embed;    ///< most urgent first
    std::vector<std::size_t> reuse;    ///< ascending
    std::vector<std::size_t> dropped;  ///< ascending; without an embedding, and over the budget
    bool embed_image = true;
    std::vector<Memory> memories;  ///< one per segment, the embeddings of `embed` still missing
    std::vector<bool> restart;     ///< per segment: forget `sum` when embedded
    Stamp stamp;
    cv::Mat labels;
  };

  EmbeddingSchedule(const ScheduleConfig& config, int crops_per_segment);

  /// Changes nothing. O(pixels in boxes + S * S' of near pairs), with a motion O(pixels).
  /// @param motion since the image before; empty: segments continue others by `min_mask_iou` only.
  Plan plan(const ColorImage& color, const LabelledSegments& segments,
            const ImageMotion& motion = {}) const;

  /// Takes in what the encoder gave and makes the plan's image the one before.
  /// @param fresh  row i belongs to plan.embed[i]; unit length, or zeros = could not be embedded.
  /// @return one row per segment; zeros for dropped ones and where the encoder failed.
  EmbeddingMatrix commit(Plan plan, const EmbeddingMatrix& fresh);

  /// How long the encoder took for so many crops; needed for `max_ms_per_frame` only.
  void addCost(std::size_t num_crops, double duration_ms);

 private:
  bool isContinued(const Plan& plan) const;
  void inherit(const ImageMotion& motion, Plan& plan) const;
  void choose(Plan& plan) const;
  std::size_t computeBudget(std::size_t num_segments) const;

  ScheduleConfig config_;
  int crops_per_segment_;
  std::vector<Memory> memories_;  ///< segments of the image before; none before the first
  Stamp stamp_;
  cv::Mat labels_;  ///< of the image before; empty before the first
  Stamp image_embedded_at_;
  double ms_per_crop_ = 0.0;  ///< running mean; 0 = not known yet
};

}  // namespace tsg::segmentation
