// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core.hpp>

#include "task_scene_graph/core/frame.h"

namespace tsg::segmentation {

/// Where an image lies in a network's square input: scaled by one factor until it fits, centred,
/// the rest grey. Pixel centres of both lie at whole numbers plus one half: u_input = u_image *
/// scale_x + left_px.
struct Letterbox {
  int input_size_px = 0;
  cv::Size image_size_px;
  cv::Rect content_px;   ///< of the image, in the input
  double scale_x = 1.0;  ///< input pixels per image pixel; differs from scale_y by rounding only
  double scale_y = 1.0;
};

/// @throws std::invalid_argument if a size is not positive.
Letterbox computeLetterbox(cv::Size image_size_px, int input_size_px);

/// Writes the image as RGB in 0..1, planar [3, S, S], padded with grey 114/255; resized bilinearly.
/// `tensor` has 3*S*S values. O(S^2 + pixels read).
void fillLetterboxTensor(const ColorImage& color, const Letterbox& letterbox, float* tensor);

}  // namespace tsg::segmentation
