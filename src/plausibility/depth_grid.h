// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "task_scene_graph/core/frame.h"

namespace tsg::plausibility {

/// Every n-th pixel of a depth image, and the camera that would have taken just these.
struct DepthGrid {
  CameraModel camera;      ///< of the grid
  std::vector<float> z_m;  ///< row by row, metres along the optical axis; 0 = invalid

  float at(int u_px, int v_px) const {
    return z_m[static_cast<std::size_t>(v_px) * static_cast<std::size_t>(camera.width_px) +
               static_cast<std::size_t>(u_px)];
  }
  float& at(int u_px, int v_px) {
    return z_m[static_cast<std::size_t>(v_px) * static_cast<std::size_t>(camera.width_px) +
               static_cast<std::size_t>(u_px)];
  }
};

/// True if the depth image has a known type and the camera's size, and the pose is finite.
bool isUsable(const RgbdFrame& frame);

/// The camera of a grid that takes every `step_px`-th pixel from `step_px / 2` on.
CameraModel computeGridCamera(const CameraModel& camera, int step_px);

/// Samples a frame that isUsable, with the least step that gives at most `max_width_px` columns.
DepthGrid sampleDepth(const RgbdFrame& frame, int max_width_px);

/// One pixel of a grid with a valid depth.
struct PixelDepth {
  float u_px = 0.0F;
  float v_px = 0.0F;
  float z_m = 0.0F;
};

/// About `count` valid pixels, spread over the grid; always the same ones.
std::vector<PixelDepth> pickPixels(const DepthGrid& grid, std::size_t count);

}  // namespace tsg::plausibility
