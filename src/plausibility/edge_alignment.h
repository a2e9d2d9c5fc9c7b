// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "depth_grid.h"
#include "task_scene_graph/plausibility/finding.h"

namespace tsg::plausibility {

/// Where colour edges lie beside depth edges. At depth edges of registered images the colour
/// changes too; summed over images, the mean colour gradient at depth edges shifted by (dx, dy) has
/// a peak at (0, 0). Not thread-safe.
class EdgeAlignment {
 public:
  static constexpr int kRadius_px = 12;  ///< of the shifts tried, in pixels of the grid
  static constexpr int kSide = 2 * kRadius_px + 1;

  /// `color`: the image that the grid's depth belongs to. O(shifts * depth edges).
  void add(const DepthGrid& depth, const cv::Mat& color);

  struct Shift {
    int dx_px = 0;  ///< colour edges lie so far right of depth edges, pixels of the grid
    int dy_px = 0;
    double significance = 0.0;  ///< height of the peak over the mean, in standard deviations
    double unshifted = 0.0;     ///< height within one pixel of no shift, as a share of the peak's
  };
  /// Nothing until enough edges were seen.
  std::optional<Shift> findShift() const;

  std::size_t numImages() const { return num_images_; }
  std::size_t numEdges() const { return num_edges_; }

 private:
  std::array<double, kSide * kSide> sums_{};
  std::size_t num_images_ = 0;
  std::size_t num_edges_ = 0;
};

/// Colour edges that lie 3 or more pixels of the grid beside the depth edges.
/// @param step_px  pixels of the image per pixel of the grid
std::optional<Finding> checkRegistration(const EdgeAlignment& alignment, int step_px);

}  // namespace tsg::plausibility
