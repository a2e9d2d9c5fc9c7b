// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "task_scene_graph/core/frame.h"

namespace tsg::mapping {

/// Smallest and largest valid depth of some pixels, metres; both 0 if none is valid.
struct DepthLimits {
  float min_m = 0.0F;
  float max_m = 0.0F;
};

/// One depth image read once per frame: metres along the optical axis in row order, 0 where the
/// reading is invalid (core/frame.h) or outside the range, and one more 0 at the end, so that an
/// index of width * height stands for "outside the image". Square tiles know their smallest and
/// largest valid depth.
class DepthBuffer {
 public:
  /// Reads the image. `tile_px` is the side of a tile, at least 1. Valid readings beyond
  /// `max_range_m` become `beyond_m`; 0 makes them invalid. Keeps its memory between frames.
  void assign(const DepthImage& depth, double min_range_m, double max_range_m, int tile_px,
              double beyond_m = 0.0);

  int width() const { return width_; }
  int height() const { return height_; }
  int tileSide() const { return tile_px_; }
  int tileColumns() const { return (width_ + tile_px_ - 1) / tile_px_; }
  int tileRows() const { return (height_ + tile_px_ - 1) / tile_px_; }

  const float* data() const { return depth_m_.data(); }
  float at(int u_px, int v_px) const { return depth_m_[index(width_, u_px, v_px)]; }

  /// Smallest and largest valid depth of a tile; both 0 if it has none.
  float tileMin(int column, int row) const {
    return tile_min_m_[index(tileColumns(), column, row)];
  }
  float tileMax(int column, int row) const {
    return tile_max_m_[index(tileColumns(), column, row)];
  }
  bool hasValidDepth() const;

  /// Of the square whose first pixel is (u, v), as far as it lies in the image. O(side^2).
  DepthLimits computeLimits(int u_px, int v_px, int side_px) const;

 private:
  static std::size_t index(int columns, int column, int row) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  }
  void finishTileRow(int tile_row);

  int width_ = 0;
  int height_ = 0;
  int tile_px_ = 1;
  std::vector<float> depth_m_;
  std::vector<float> column_min_m_;
  std::vector<float> column_max_m_;
  std::vector<float> tile_min_m_;
  std::vector<float> tile_max_m_;
};

}  // namespace tsg::mapping
