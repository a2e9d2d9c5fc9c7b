// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "task_scene_graph/core/frame.h"

namespace tsg::loops {

/// Points in metres, finite.
using Points = std::vector<Eigen::Vector3f>;

/// One point for each cell of `voxel_m`: the mean of the points in it, in the order in which cells
/// were met. O(points). @throws std::invalid_argument unless voxel_m > 0.
Points downsample(const Points& points, float voxel_m);

/// What a depth image shows up to `max_range_m`, in the camera's frame, one point for each cell of
/// `voxel_m`. Depth that jumps between neighbours is left out: it is no surface. O(pixels).
Points makeCloud(const DepthImage& depth, const CameraModel& camera, float voxel_m,
                 float max_range_m);

/// T_a_b * points.
Points transform(const Pose& T_a_b, const Points& points);

}  // namespace tsg::loops
