// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "task_scene_graph/segmentation/letterbox.h"

namespace tsg::segmentation {

/// The two outputs of a FastSAM-shaped network (YOLOv8-seg) for one image of S x S pixels.
struct RawDetections {
  const float* predictions = nullptr;  ///< [4 + C + K, A]: cx, cy, w, h (px), C scores, K weights
  const float* prototypes = nullptr;   ///< [K, P, P]: mask logits are weighted sums of these
  std::size_t num_anchors = 0;         ///< A
  int num_classes = 0;                 ///< C, 1 in FastSAM; the greatest score counts
  int num_prototypes = 0;              ///< K
  int prototype_size_px = 0;           ///< P
  std::shared_ptr<const void> owner;   ///< of predictions that had to be copied, or null
};

/// A candidate: a box in the network's input and where its numbers lie.
struct Detection {
  cv::Rect2f box_px;  ///< in the network's input
  float score = 0.0F;
  std::size_t anchor = 0;
};

/// The candidates whose score exceeds the threshold and whose box is finite and not empty, best
/// first (ties by anchor). O(A).
std::vector<Detection> findCandidates(const RawDetections& raw, double score_threshold);

/// Greedy, class-agnostic non-maximum suppression: walking down the list, a candidate is dropped if
/// its IoU with one kept before exceeds the threshold; ends after `max_kept`. O(n * kept).
std::vector<Detection> suppressOverlaps(const std::vector<Detection>& best_first,
                                        double iou_threshold, std::size_t max_kept);

/// One object's pixels.
struct SegmentMask {
  cv::Rect box_px;  ///< in the image
  cv::Mat mask;     ///< box_px.size(), CV_8UC1, 1 = belongs to the object
  int area_px = 0;  ///< number of ones
  float score = 0.0F;
};

/// The detection's mask at image resolution: logits interpolated bilinearly from the prototypes'
/// grid (without its padding), positive = object, cut at the box. Computed inside the box only:
/// O(K * box on the prototype grid + box in the image).
SegmentMask decodeMask(const RawDetections& raw, const Detection& detection,
                       const Letterbox& letterbox);

}  // namespace tsg::segmentation
