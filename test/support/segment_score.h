// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace tsg::test {

/// A true thing in an image and the segment that shows it.
struct ThingMatch {
  int thing = 0;                       ///< its value in the image of true labels
  std::optional<std::size_t> segment;  ///< from 0, the one of the highest IoU; none below the least
};

/// Every thing of more than `min_area_px` pixels, ascending. O(pixels + things * segments).
/// @param truth   CV_16UC1, 0 = nothing
/// @param labels  CV_16UC1, 0 = no segment, segment s has s + 1; same size
std::vector<ThingMatch> matchThings(const cv::Mat& truth, const cv::Mat& labels, int min_area_px,
                                    double min_iou);

}  // namespace tsg::test
