// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <utility>
#include <vector>

namespace tsg::places {

/// What a body that stands on a floor meets at one cell.
struct PlanCell {
  enum class State : std::uint8_t {
    kUnknown,  ///< not observed, or not wholly
    kFree,     ///< a body's axis can stand here
    kObstacle  ///< something solid stands in the way of a body
  };

  State state = State::kUnknown;
  float floor_m = std::numeric_limits<float>::quiet_NaN();  ///< world z of the (nearest) floor
  float clearance_m = 0.0F;  ///< free cells: horizontal distance to the nearest observed obstacle

  bool isFree() const { return state == State::kFree; }
};

bool operator==(const PlanCell& a, const PlanCell& b);

/// Ground plan of all floors, sparse: tiles of 8 x 8 square cells, several one over another where
/// floors are (storeys, stairs over a room). Cells of one floor that touch differ in height by no
/// more than a step. World frame, z up. A copy shares its tiles with the original, and a tile never
/// changes, so a copy is a snapshot that costs O(tiles) pointers; reading it needs no lock.
class GroundPlan {
 public:
  static constexpr int kTileSide = 8;

  /// Position of a cell or tile in the plane: cell (x, y) covers [x, x + 1) * cellSize().
  using Index = std::pair<int, int>;
  using Tile = std::array<PlanCell, kTileSide * kTileSide>;  ///< x fastest
  using TilePtr = std::shared_ptr<const Tile>;

  explicit GroundPlan(double cell_size_m = 0.1) : cell_size_m_(cell_size_m) {}

  double cellSize() const { return cell_size_m_; }

  /// Replaces all tiles at a position; none removes them. Order: any, kept.
  void setTiles(const Index& tile, std::vector<TilePtr> tiles);
  /// The tiles at a position, one for each floor; empty if there is none.
  const std::vector<TilePtr>& tilesAt(const Index& tile) const;
  const std::map<Index, std::vector<TilePtr>>& tiles() const { return tiles_; }

  /// The cell that covers a position: of all floors there the one whose height is nearest to
  /// `floor_m`; null if no cell with a floor height is there within `max_step_m` of it.
  const PlanCell* find(const Index& cell, double floor_m, double max_step_m) const;

  Index computeCell(const Eigen::Vector2d& p_m) const;
  Eigen::Vector2d computeCenter(const Index& cell) const;

 private:
  double cell_size_m_;
  std::map<Index, std::vector<TilePtr>> tiles_;
};

/// value / divisor, rounded down also below 0. Precondition: divisor > 0.
int divideFloor(int value, int divisor);

/// Tile that holds a cell, and the cell's place in it.
GroundPlan::Index computeTile(const GroundPlan::Index& cell);
std::size_t computeOffset(const GroundPlan::Index& cell);

}  // namespace tsg::places
