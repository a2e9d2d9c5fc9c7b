// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "task_scene_graph/places/ground_plan.h"

namespace tsg::planning {

/// A ground plan made ready for searching: each cell of each floor is a node, and knows its
/// neighbours without looking anything up. Immutable, so any number of threads may read it.
class NavigationGrid {
 public:
  using Node = std::uint32_t;
  using Index = places::GroundPlan::Index;
  static constexpr Node kNone = 0xFFFFFFFFU;
  static constexpr Node kTileCells = 64;
  static_assert(kTileCells == places::GroundPlan::kTileSide * places::GroundPlan::kTileSide);

  /// @param max_step_m  neighbouring cells are one floor if their heights differ by no more
  /// O(tiles).
  NavigationGrid(places::GroundPlan plan, double max_step_m);

  const places::GroundPlan& plan() const { return plan_; }
  double maxStep() const { return max_step_m_; }
  double cellSize() const { return plan_.cellSize(); }
  std::size_t numTiles() const { return tiles_.size(); }
  std::size_t numNodes() const { return tiles_.size() * kTileCells; }

  const places::PlanCell& cell(Node node) const {
    return (*tiles_[node / kTileCells].cells)[node % kTileCells];
  }
  Index computeIndex(Node node) const;
  Eigen::Vector2d computeCenter(Node node) const { return plan_.computeCenter(computeIndex(node)); }
  /// Centre of the cell, on its floor.
  Eigen::Vector3d computePosition(Node node) const;

  /// The cell beside another on the same floor; kNone if there is none. dx, dy in {-1, 0, 1}.
  Node findNeighbour(Node from, int dx, int dy) const;
  /// The floor that a body at `p_m` stands on: the highest at most a step above it, or else the
  /// lowest of all. kNone if no cell with a floor height covers it. O(log(tiles)).
  Node findFloor(const Eigen::Vector3d& p_m) const;

  /// Bilinear between the centres of cells: obstacles have none, what is unknown does not count.
  /// @param node  free, covers `p_m`
  double computeClearance(Node node, const Eigen::Vector2d& p_m) const;
  /// True for a free cell in which the robot's axis may be at `p_m`.
  bool isClear(Node node, const Eigen::Vector2d& p_m, double radius_m) const;
  /// True for a free cell in whose centre the robot's axis may be.
  bool isPassable(Node node, double radius_m) const {
    return cell(node).isFree() && static_cast<double>(cell(node).clearance_m) >= radius_m;
  }
  /// Walks straight on the floor from `a_m`, which `from` covers, to `b_m`; looks twice per cell.
  /// @return the cell that covers b_m, or kNone if the robot's axis cannot walk there
  Node walk(Node from, const Eigen::Vector2d& a_m, const Eigen::Vector2d& b_m,
            double radius_m) const;

 private:
  /// Tiles are kept by position; those of one position follow each other.
  struct TileEntry {
    const places::GroundPlan::Tile* cells = nullptr;
    Index index;
    std::array<std::uint32_t, 9> first{};  ///< of the positions around, x fastest; 4 = its own
    std::array<std::uint8_t, 9> count{};
  };

  void linkTiles();

  places::GroundPlan plan_;
  double max_step_m_;
  std::vector<TileEntry> tiles_;
};

}  // namespace tsg::planning
