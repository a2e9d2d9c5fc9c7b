// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <opencv2/core.hpp>
#include <vector>

#include "task_scene_graph/segmentation/mask_decoder.h"

namespace tsg::segmentation {

/// A disjoint partition of an image. Segment s has label s, counted from 1.
struct LabelledSegments {
  cv::Mat labels;                  ///< CV_16UC1
  std::vector<float> scores;       ///< S
  std::vector<cv::Rect> boxes_px;  ///< S, tight
  std::vector<int> areas_px;       ///< S
};

/// Paints masks from the largest to the smallest, so that the smaller one wins overlaps.
/// `refine`: keeps of every segment only what a 3x3 erosion followed by a 3x3 dilation leaves (thin
/// bridges and specks go). Segments with fewer than max(1, min_area_px) pixels are dropped; the
/// others keep their order in `masks`. O(pixels + sum of boxes).
/// @throws std::invalid_argument for more than 65535 masks.
LabelledSegments paintLabels(const std::vector<SegmentMask>& masks, cv::Size image_size_px,
                             bool refine, int min_area_px);

/// The segments of a label image, label s + 1 having score s. Those with fewer than
/// max(1, min_area_px) pixels are dropped; the others keep their order and get the labels 1, 2, ...
/// O(pixels). @param labels CV_16UC1, is changed where labels do.
LabelledSegments collectSegments(const cv::Mat& labels, const std::vector<float>& scores,
                                 int min_area_px);

/// Removes segments, given by their ascending indices from 0; the others keep their order and get
/// the labels 1, 2, ... O(pixels), nothing if there is none to remove.
void dropSegments(const std::vector<std::size_t>& dropped, LabelledSegments& segments);

}  // namespace tsg::segmentation
