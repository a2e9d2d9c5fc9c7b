// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "task_scene_graph/places/free_space.h"
#include "task_scene_graph/places/places_config.h"

namespace tsg::places {

struct SparsePlace {
  std::size_t cell = 0;  ///< the voxel of the set with the largest clearance
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double clearance_m = 0.0;
};

struct SparseEdge {
  std::size_t a = 0;  ///< index of a place, a < b
  std::size_t b = 0;
  double clearance_m = 0.0;  ///< smallest along the straight line
};

struct SparseGraph {
  std::vector<SparsePlace> places;
  std::vector<SparseEdge> edges;

  /// Appends a graph that shares no place with this one.
  void append(const SparseGraph& other);
};

/// Places for open space without any: a ground plan's coarse cells get a place as near to their
/// middle as can be, at least `fill_distance_m` from every other place, with `min_clearance_m`.
/// O(cells).
std::vector<SparsePlace> findFillPlaces(const FreeSpace& space,
                                        const std::vector<SparsePlace>& places,
                                        const PlacesConfig& config);

/// Sparsifies Voronoi cells: connected sets within cells of `cell_size_m` become places, sets that
/// touch become edges if the straight line is free with `min_edge_clearance_m`, open space of a
/// ground plan is filled (findFillPlaces) and joined to places within 1.5 cells, parts that are
/// apart are joined by the shortest such lines up to `max_bridge_m`, and parts of fewer than
/// `min_component_size` places are left out. [Hydra22, Sec. IV-B]
SparseGraph computeSparseGraph(const FreeSpace& space, const std::vector<char>& is_voronoi,
                               const PlacesConfig& config);

}  // namespace tsg::places
