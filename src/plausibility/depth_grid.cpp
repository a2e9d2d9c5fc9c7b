// SPDX-License-Identifier: BSD-3-Clause
#include "depth_grid.h"

#include <algorithm>
#include <cmath>

namespace tsg::plausibility {

bool isUsable(const RgbdFrame& frame) {
  const cv::Mat& depth = frame.depth.image;
  const bool has_type = depth.type() == CV_16UC1 || depth.type() == CV_32FC1;
  return has_type && depth.cols == frame.camera.width_px && depth.rows == frame.camera.height_px &&
         depth.cols > 0 && depth.rows > 0 && frame.camera.fx_px > 0.0 && frame.camera.fy_px > 0.0 &&
         frame.depth.metres_per_unit > 0.0 && frame.T_world_camera.matrix().allFinite();
}

CameraModel computeGridCamera(const CameraModel& camera, int step_px) {
  const int offset_px = step_px / 2;
  const auto count = [&](int size_px) { return (size_px - offset_px + step_px - 1) / step_px; };
  return {count(camera.width_px),
          count(camera.height_px),
          camera.fx_px / step_px,
          camera.fy_px / step_px,
          (camera.cx_px - offset_px) / step_px,
          (camera.cy_px - offset_px) / step_px};
}

DepthGrid sampleDepth(const RgbdFrame& frame, int max_width_px) {
  const int step_px = (frame.camera.width_px + max_width_px - 1) / max_width_px;
  DepthGrid grid;
  grid.camera = computeGridCamera(frame.camera, step_px);
  grid.z_m.reserve(static_cast<std::size_t>(grid.camera.width_px) *
                   static_cast<std::size_t>(grid.camera.height_px));
  for (int v = 0; v < grid.camera.height_px; ++v) {
    for (int u = 0; u < grid.camera.width_px; ++u) {
      grid.z_m.push_back(frame.depth.at(step_px / 2 + u * step_px, step_px / 2 + v * step_px));
    }
  }
  return grid;
}

std::vector<PixelDepth> pickPixels(const DepthGrid& grid, std::size_t count) {
  const double area = static_cast<double>(grid.z_m.size());
  const int step_px = std::max(
      1, static_cast<int>(std::sqrt(area / static_cast<double>(std::max<std::size_t>(count, 1)))));
  std::vector<PixelDepth> pixels;
  for (int v = step_px / 2; v < grid.camera.height_px; v += step_px) {
    for (int u = step_px / 2; u < grid.camera.width_px; u += step_px) {
      const float z_m = grid.at(u, v);
      if (z_m > 0.0F) pixels.push_back({static_cast<float>(u), static_cast<float>(v), z_m});
    }
  }
  return pixels;
}

}  // namespace tsg::plausibility
