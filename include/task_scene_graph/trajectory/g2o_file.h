// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "task_scene_graph/trajectory/pose_graph.h"

namespace tsg::trajectory {

/// Reads a pose graph in g2o's text format: lines `VERTEX_SE3:QUAT id x y z qx qy qz qw` and
/// `EDGE_SE3:QUAT a b x y z qx qy qz qw` with the 21 numbers of the information's upper triangle,
/// row by row; `#` begins a comment, `FIX id` is left out: the first keyframe stays. Edges from one
/// id to the next are odometry, all others loop closures. Ids become ids of keyframes plus 1, as
/// theirs begin at 0.
///
/// g2o's error is the vector part of a quaternion, half of ours: information of rotations is
/// divided by 4, that between rotation and translation by 2, so that chi2 is the same as g2o's.
/// @throws std::runtime_error naming the file, the line and what was expected.
PoseGraph loadG2o(const std::string& path, const PoseGraphConfig& config = {});

}  // namespace tsg::trajectory
