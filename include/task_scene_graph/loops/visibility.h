// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/loops/local_cloud.h"

namespace tsg::loops {

/// What one camera saw, small: how far space was free in each direction.
struct DepthView {
  Pose T_scene_camera = Pose::Identity();
  CameraModel camera;            ///< of the cells
  std::vector<float> nearest_m;  ///< depth of the nearest reading of each cell, row by row; 0: none
};

/// Cells of `cell_px` squared; one that lacks half of its readings is 0. In the camera's frame.
/// O(pixels).
DepthView makeDepthView(const DepthImage& depth, const CameraModel& camera, int cell_px);

/// How two scenes see each other's surfaces.
struct Visibility {
  std::size_t num_seen = 0;     ///< points where a view of the other scene measured them
  std::size_t num_through = 0;  ///< ... that a view looked through, and none measured
  /// Of both, 0 if there are none.
  double shareThrough() const;
};

/// Points of one scene in the views of another. A point is looked through if the nearest reading of
/// its cell lies farther by more than `margin_m` and 5 % of its depth. O(points * views).
Visibility lookAt(const Points& points, const Pose& T_views_points,
                  const std::vector<DepthView>& views, double margin_m);

Visibility operator+(const Visibility& a, const Visibility& b);

}  // namespace tsg::loops
