// SPDX-License-Identifier: BSD-3-Clause
#include "grid_search.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
#include <utility>

namespace tsg::planning {
namespace {

using Node = NavigationGrid::Node;

struct SearchNote {
  float cost = std::numeric_limits<float>::infinity();  ///< cells
  Node parent = NavigationGrid::kNone;
  bool is_done = false;
  bool is_goal = false;
};

using Notes = CellNotes<SearchNote>;
/// Estimated total cost, cell; the smallest first.
using Queue = std::priority_queue<std::pair<float, Node>, std::vector<std::pair<float, Node>>,
                                  std::greater<std::pair<float, Node>>>;

float computeMoveCost(int dx, int dy) { return dx != 0 && dy != 0 ? 1.41421356F : 1.0F; }

std::vector<Node> traceBack(Notes& notes, Node end) {
  std::vector<Node> way;
  for (Node at = end; at != NavigationGrid::kNone; at = notes[at].parent) way.push_back(at);
  std::reverse(way.begin(), way.end());
  return way;
}

/// Never more than the cost of the king's moves to the nearest goal, cells.
class Estimate {
 public:
  Estimate(const NavigationGrid& grid, const GridGoals& goals)
      : grid_(grid),
        focus_(goals.focus_m / grid.cellSize()),
        reach_(static_cast<float>(goals.reach_m / grid.cellSize())) {}

  float operator()(Node node) const {
    const NavigationGrid::Index index = grid_.computeIndex(node);
    const double x = std::abs(index.first + 0.5 - focus_.x());
    const double y = std::abs(index.second + 0.5 - focus_.y());
    // A king's distance is a norm, at most 1.083 times the straight one.
    const double octile = std::max(x, y) + (std::sqrt(2.0) - 1.0) * std::min(x, y);
    return std::max(0.0F, static_cast<float>(octile) - 1.083F * reach_);
  }

 private:
  const NavigationGrid& grid_;
  Eigen::Vector2d focus_;
  float reach_;
};

}  // namespace

std::vector<Node> searchGrid(const NavigationGrid& grid, Node start, const GridGoals& goals,
                             const GridSearchOptions& options) {
  const Estimate estimate(grid, goals);
  const auto max_cost = static_cast<float>(options.max_length_m / grid.cellSize());
  Notes notes(grid);
  for (const Node goal : goals.nodes) notes[goal].is_goal = true;
  Queue queue;
  notes[start].cost = 0.0F;
  queue.emplace(estimate(start), start);
  std::size_t cells = 0;
  while (!queue.empty()) {
    const Node at = queue.top().second;
    queue.pop();
    if (std::exchange(notes[at].is_done, true)) continue;
    if (notes[at].is_goal) return traceBack(notes, at);
    if (++cells > options.max_cells) return {};
    const float cost = notes[at].cost;
    forEachMove(grid, at, options.radius_m, [&](int dx, int dy, Node next) {
      SearchNote& note = notes[next];
      const float next_cost = cost + computeMoveCost(dx, dy);
      if (note.is_done || next_cost >= note.cost) return;
      const float total = next_cost + estimate(next);
      if (total > max_cost) return;
      note.cost = next_cost;
      note.parent = at;
      queue.emplace(total, next);
    });
  }
  return {};
}

std::vector<Node> findRoom(const NavigationGrid& grid, Node from, double radius_m,
                           double max_distance_m) {
  const auto max_cost = static_cast<float>(max_distance_m / grid.cellSize());
  Notes notes(grid);
  Queue queue;
  notes[from].cost = 0.0F;
  queue.emplace(0.0F, from);
  while (!queue.empty()) {
    const Node at = queue.top().second;
    queue.pop();
    if (std::exchange(notes[at].is_done, true)) continue;
    if (grid.isPassable(at, radius_m)) return traceBack(notes, at);
    forEachMove(grid, at, 0.0, [&](int dx, int dy, Node next) {
      SearchNote& note = notes[next];
      const float cost = notes[at].cost + computeMoveCost(dx, dy);
      if (note.is_done || cost >= note.cost || cost > max_cost) return;
      note.cost = cost;
      note.parent = at;
      queue.emplace(cost, next);
    });
  }
  return {};
}

}  // namespace tsg::planning
