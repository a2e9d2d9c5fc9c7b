// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/places/ground_plan.h"

namespace tsg::test {

/// A rectangle seen from above.
struct PlanRect {
  Eigen::Vector2d min_m;
  Eigen::Vector2d max_m;

  bool contains(const Eigen::Vector2d& p_m) const {
    return (p_m.array() >= min_m.array()).all() && (p_m.array() < max_m.array()).all();
  }
  double computeDistance(const Eigen::Vector2d& p_m) const {
    return (min_m - p_m).cwiseMax(p_m - max_m).cwiseMax(0.0).norm();
  }
};

/// A level of a drawn building: floors, and what stands on them.
class PlanLevel {
 public:
  /// Floor that rises along x from `z_m` by `rise` per metre.
  PlanLevel& addFloor(const PlanRect& rect, double z_m = 0.0, double rise = 0.0);
  PlanLevel& addObstacle(const PlanRect& rect);
  /// A floor with walls of 0.2 m round it, outside.
  PlanLevel& addRoom(const PlanRect& rect);

  std::optional<double> findFloor(const Eigen::Vector2d& p_m) const;
  bool isObstacle(const Eigen::Vector2d& p_m) const;
  /// Distance to the nearest obstacle, at most 5 m.
  double computeClearance(const Eigen::Vector2d& p_m) const;
  /// True if a circle can stand on the floor at every point of the line.
  bool isFree(const Eigen::Vector2d& a_m, const Eigen::Vector2d& b_m, double radius_m) const;

  /// All floors and obstacles.
  std::vector<PlanRect> extents() const;

 private:
  struct Floor {
    PlanRect rect;
    double z_m = 0.0;
    double rise = 0.0;
  };
  std::vector<Floor> floors_;
  std::vector<PlanRect> obstacles_;
};

/// The ground plan of levels: each is a tile of its own wherever it has a floor or an obstacle.
places::GroundPlan drawPlan(const std::vector<PlanLevel>& levels, double cell_size_m = 0.1);

/// Places on a lattice where there is `min_clearance_m` (0.5 m above the floor), edges between
/// those at most 1.5 lattice steps apart with a free line; levels are joined where their places are
/// so near as well.
PlaceGraph drawPlaces(const std::vector<PlanLevel>& levels, const PlanRect& extent,
                      double lattice_m = 0.9, double min_clearance_m = 0.3);

/// Length of the shortest way of a circle on one level: Dijkstra on a lattice of `lattice_m` with
/// 40 directions, at most 0.8 % too long besides what the lattice misses; infinite if there is
/// none.
double computeShortestWay(const PlanLevel& level, const PlanRect& extent,
                          const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m,
                          double radius_m, double lattice_m = 0.05);

}  // namespace tsg::test
