// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core.hpp>

namespace tsg::segmentation {

/// A part of an image resized with the cubic kernel (a = -1/2) stretched by the scale when
/// shrinking (antialias), 8-bit fixed-point arithmetic, columns before rows: bit-identical to
/// Pillow's `resize(resized_px, BICUBIC)`, which CLIP's networks were trained with (OpenCV's
/// INTER_CUBIC does not antialias).
/// @param image CV_8UC3; @param resized_px size of the whole result; @param window_px the part of
/// it that is wanted. Cost: O(window * kernel), whatever lies outside is not computed.
/// @throws std::invalid_argument for another type, empty sizes, or a window that is not inside.
cv::Mat resizeBicubic(const cv::Mat& image, cv::Size resized_px, cv::Rect window_px);

}  // namespace tsg::segmentation
