// SPDX-License-Identifier: BSD-3-Clause
#include "segment_carrier.h"

namespace tsg::segmentation {

std::optional<LabelledSegments> SegmentCarrier::carry(Stamp stamp, const ImageMotion& motion) {
  const double gap_s = secondsBetween(stamp_, stamp);
  const bool is_continued = !motion.isEmpty() && segments_.labels.size() == motion.image_size_px &&
                            gap_s > 0.0 && gap_s <= config_.max_gap_s;
  if (!is_continued || num_skipped_ >= config_.max_skipped_images) return std::nullopt;
  known_share_ *= motion.computeKnownShare();
  if (known_share_ < config_.min_known_share) return std::nullopt;
  return collectSegments(moveLabels(segments_.labels, motion), segments_.scores, min_area_px_);
}

void SegmentCarrier::setSegments(Stamp stamp, const LabelledSegments& segments, bool are_carried) {
  segments_ = segments;
  stamp_ = stamp;
  num_skipped_ = are_carried ? num_skipped_ + 1 : 0;
  if (!are_carried) known_share_ = 1.0;
}

}  // namespace tsg::segmentation
