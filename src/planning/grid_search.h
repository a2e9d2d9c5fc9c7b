// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <deque>
#include <limits>
#include <vector>

#include "navigation_grid.h"

namespace tsg::planning {

/// What a search has noted of cells; memory only for tiles that it came to.
template <typename Note>
class CellNotes {
 public:
  explicit CellNotes(const NavigationGrid& grid) : slots_(grid.numTiles(), 0) {}

  Note& operator[](NavigationGrid::Node node) {
    std::uint32_t& slot = slots_[node / NavigationGrid::kTileCells];
    if (slot == 0) {
      tiles_.emplace_back();
      slot = static_cast<std::uint32_t>(tiles_.size());
    }
    return tiles_[slot - 1][node % NavigationGrid::kTileCells];
  }

 private:
  std::vector<std::uint32_t> slots_;  ///< 1 + index into `tiles_`; 0 = none
  std::deque<std::array<Note, NavigationGrid::kTileCells>> tiles_;
};

struct GridSearchOptions {
  double radius_m = 0.0;
  std::size_t max_cells = std::numeric_limits<std::size_t>::max();  ///< looked at
  double max_length_m = std::numeric_limits<double>::infinity();    ///< longer ones do not count
};

/// The cells that a search is to reach, all within `reach_m` of `focus_m`.
struct GridGoals {
  std::vector<NavigationGrid::Node> nodes;
  Eigen::Vector2d focus_m = Eigen::Vector2d::Zero();
  double reach_m = 0.0;
};

/// Moves of a king from centre to centre over passable cells; corners are not cut.
/// f(dx, dy, node) for each cell that can be moved to.
template <typename Function>
void forEachMove(const NavigationGrid& grid, NavigationGrid::Node from, double radius_m,
                 const Function& f) {
  const auto at = [&](int dx, int dy) {
    const NavigationGrid::Node node = grid.findNeighbour(from, dx, dy);
    return node != NavigationGrid::kNone && grid.isPassable(node, radius_m) ? node
                                                                            : NavigationGrid::kNone;
  };
  const std::array<NavigationGrid::Node, 2> x{at(-1, 0), at(1, 0)};
  const std::array<NavigationGrid::Node, 2> y{at(0, -1), at(0, 1)};
  for (std::size_t i = 0; i < 2; ++i) {
    const int sign = i == 0 ? -1 : 1;
    if (x[i] != NavigationGrid::kNone) f(sign, 0, x[i]);
    if (y[i] != NavigationGrid::kNone) f(0, sign, y[i]);
    for (std::size_t j = 0; j < 2; ++j) {
      if (x[i] == NavigationGrid::kNone || y[j] == NavigationGrid::kNone) continue;
      const int sign_y = j == 0 ? -1 : 1;
      const NavigationGrid::Node node = at(sign, sign_y);
      if (node != NavigationGrid::kNone) f(sign, sign_y, node);
    }
  }
}

/// Shortest way of a king's moves from a passable cell to the nearest goal (A*): cells, both ends
/// included; empty if there is none within the limits. O(cells looked at * log).
std::vector<NavigationGrid::Node> searchGrid(const NavigationGrid& grid, NavigationGrid::Node start,
                                             const GridGoals& goals,
                                             const GridSearchOptions& options);

/// The cell nearest to a position (by the way to it over free cells, at most `max_distance_m`) in
/// which the robot has room, with the way to it; empty if there is none. `from` itself may be
/// narrow.
std::vector<NavigationGrid::Node> findRoom(const NavigationGrid& grid, NavigationGrid::Node from,
                                           double radius_m, double max_distance_m);

}  // namespace tsg::planning
