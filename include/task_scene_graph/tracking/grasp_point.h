// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "task_scene_graph/core/embedding.h"
#include "task_scene_graph/core/frame.h"

namespace tsg::tracking {

/// Where to reach for a segment.
struct GraspPoint {
  std::uint16_t segment = 0;  ///< label
  std::uint32_t num_pixels = 0;
  double score = 0.0;   ///< cosine of its embedding to the question, in [-1, 1]
  double margin = 0.0;  ///< score less that of the next best segment; 0 if there is none
  int u_px = 0;
  int v_px = 0;
  Eigen::Vector3d p_camera = Eigen::Vector3d::Zero();  ///< on the thing's surface, metres
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
};

/// The centroid of the segment of highest cosine to a question [Clio24, Sec. V-D], and its point
/// in space.
/// deviation: the paper hands the centroid itself on. That of a ring or a crescent lies beside it,
/// so the segment's pixel nearest to the centroid is taken; its depth is the median of those of the
/// segment within 2 px of it, since single pixels at edges have none, or that of what is behind.
/// @param segmentation  in the pixels of `frame` (alignToFrame())
/// @param question      size D, a direction
/// @throws std::invalid_argument for a question that is zero, not finite or of another size;
/// std::runtime_error if the image has no segments, none with an embedding, or there is no depth.
/// O(S D + pixels).
GraspPoint findGraspPoint(const RgbdFrame& frame, const Segmentation& segmentation,
                          const Embedding& question);

}  // namespace tsg::tracking
