// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>

#include "task_scene_graph/core/frame.h"

namespace tsg::segmentation {

/// What a segment looks like, coarsely: its mask and its colours on a grid of 8x8 cells over its
/// box. Where it is does not matter, how large it is does.
struct Appearance {
  static constexpr std::size_t kSide = 8;
  static constexpr std::size_t kCells = kSide * kSide;

  cv::Size size_px;                      ///< of the box
  std::array<float, kCells> coverage{};  ///< row-major, the mask's share of each cell
  std::array<std::array<float, 3>, kCells> rgb_8bit{};  ///< mean colour of the mask in each cell
};

/// Of the pixels in `box_px` that have this label. Reads about 64x64 evenly spread pixels of larger
/// boxes. `box_px` is not empty and lies in the image.
Appearance computeAppearance(const ColorImage& color, const cv::Mat& labels, const cv::Rect& box_px,
                             std::uint16_t label);

/// IoU in [0, 1] of two masks of which one was moved so that the boxes' corners meet, up to the
/// grid: the cells' IoU times the smaller box's share of the larger one, side by side. Symmetric;
/// 1 for the same mask.
double computeMaskIou(const Appearance& a, const Appearance& b);

/// Mean absolute difference of the colours, in 8-bit steps, over what both masks cover; 255 if that
/// is nothing. Symmetric; 0 for the same appearance.
double computeColorChange(const Appearance& a, const Appearance& b);

/// Mean absolute difference of the masks' mean colours, in 8-bit steps; 255 if a mask is empty.
/// Unlike computeColorChange, it hardly changes where only a part of the thing is seen. Symmetric.
double computeMeanColorChange(const Appearance& a, const Appearance& b);

}  // namespace tsg::segmentation
