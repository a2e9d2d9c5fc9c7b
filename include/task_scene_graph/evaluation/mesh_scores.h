// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "task_scene_graph/core/mesh.h"

namespace tsg::evaluation {

struct MeshScoresConfig {
  double threshold_m = 0.05;    ///< what counts as right
  double max_distance_m = 0.5;  ///< larger distances count as this
};

/// How far a map's mesh is off the true surfaces; over its vertices, to the nearest point of any
/// true triangle.
struct MeshScores {
  std::size_t num_vertices = 0;
  double mean_m = 0.0;
  double rms_m = 0.0;
  double percentile95_m = 0.0;
  double right = 0.0;  ///< share of vertices within the threshold
};

/// What nobody saw is not asked for: the true mesh may show more than the map.
/// @throws std::invalid_argument if one mesh is empty, a true vertex is not finite or beyond
/// 1e6 m, or the true surfaces are larger than about a square kilometre. O(triangles * cells that
/// they touch + vertices * triangles around them).
MeshScores computeMeshScores(const Mesh& mesh, const Mesh& truth,
                             const MeshScoresConfig& config = {});

}  // namespace tsg::evaluation
