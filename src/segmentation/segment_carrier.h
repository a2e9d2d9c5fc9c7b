// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/segmentation/embedding_schedule.h"
#include "task_scene_graph/segmentation/image_motion.h"
#include "task_scene_graph/segmentation/label_painter.h"

namespace tsg::segmentation {

/// Decides which images the segmenting network may skip, and moves the segments of the image before
/// with the image there: at most `max_skipped_images` in a row, as long as `min_known_share` of the
/// image has been in view, looking the same, since the network last ran. Thread safety: one thread.
class SegmentCarrier {
 public:
  SegmentCarrier(const ScheduleConfig& config, int min_area_px)
      : config_(config), min_area_px_(min_area_px) {}

  /// The segments of an image that may be skipped; nothing: the network has to run. O(pixels).
  std::optional<LabelledSegments> carry(Stamp stamp, const ImageMotion& motion);

  /// The segments that an image ended up with, found or carried; every image's, in turn.
  void setSegments(Stamp stamp, const LabelledSegments& segments, bool are_carried);

 private:
  ScheduleConfig config_;
  int min_area_px_;
  LabelledSegments segments_;  ///< of the image before
  Stamp stamp_;
  int num_skipped_ = 0;       ///< since the network last ran
  double known_share_ = 0.0;  ///< of the newest image, in view since then
};

}  // namespace tsg::segmentation
