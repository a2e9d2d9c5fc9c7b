// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "task_scene_graph/segmentation/embedding_schedule.h"

namespace tsg::segmentation {

inline cv::Point2d computeCenter(const cv::Rect& box) {
  return {box.x + box.width / 2.0, box.y + box.height / 2.0};
}

/// The segments of one image.
struct SegmentsSeen {
  const std::vector<EmbeddingSchedule::Memory>& memories;
  const cv::Mat& labels;
};

/// For each segment the one of the image before that it continues (see EmbeddingSchedule).
/// O(S * S'), with a motion O(pixels) more.
std::vector<std::optional<std::size_t>> findPredecessors(const SegmentsSeen& now,
                                                         const SegmentsSeen& earlier,
                                                         const ImageMotion& motion,
                                                         const ScheduleConfig& config);

}  // namespace tsg::segmentation
