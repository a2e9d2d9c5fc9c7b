// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core.hpp>

#include "task_scene_graph/core/frame.h"

namespace tsg::segmentation {

/// The image with its segments half transparent over it, in colours that differ between
/// neighbouring labels, and white lines between them; in the image's channel order. O(pixels).
/// @param image   CV_8UC3
/// @param labels  CV_16UC1, 0 = no segment: left as it is
/// @throws std::invalid_argument if sizes or types are others.
cv::Mat drawSegments(const cv::Mat& image, const cv::Mat& labels, ColorOrder order);

}  // namespace tsg::segmentation
