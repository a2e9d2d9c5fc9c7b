// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>

#include "task_scene_graph/core/mesh.h"
#include "task_scene_graph/places/ground_plan.h"

/// Where a robot can go in a world whose surfaces are known.
namespace tsg::evaluation {

/// The robot and the cells; as places/body_height_m and places/max_step_m of a map.
struct TrueFloorConfig {
  double cell_size_m = 0.05;
  double body_height_m = 1.2;
  double max_step_m = 0.2;
};

/// Vertices and faces of a PLY file; faces of more than three corners become fans of triangles.
/// Colours are left out. A map whose walk saw no surface has a mesh without faces.
/// @throws std::runtime_error naming the file, what was found and what was expected.
Mesh loadMesh(const std::string& path);

/// The same of what there must be something of. @throws also where it has no faces.
Mesh loadTrueMesh(const std::string& path);

/// The floor that can be walked to from a point: of each cell the highest surface at most a step
/// above or below a neighbour's, free where no surface is between a step and the body's height
/// above it, and else an obstacle. Cells without a surface near the neighbours' height are unknown.
/// Clearances reach from a cell's centre to the nearest obstacle cell's edge (half a cell before
/// its centre), at most 5 m. Surfaces are sampled every half cell.
/// @param start_m  world; above its floor
/// @throws std::invalid_argument if the mesh covers more than 100 million cells, or there is no
/// free floor under the start.
/// O(area / cell^2 + cells * sqrt(obstacles)).
places::GroundPlan computeTrueFloor(const Mesh& mesh, const Eigen::Vector3d& start_m,
                                    const TrueFloorConfig& config = {});

}  // namespace tsg::evaluation
