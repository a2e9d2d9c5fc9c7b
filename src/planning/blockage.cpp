// SPDX-License-Identifier: BSD-3-Clause
#include "blockage.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <queue>
#include <tuple>
#include <utility>

#include "grid_search.h"

namespace tsg::planning {
namespace {

using Node = NavigationGrid::Node;
using State = places::PlanCell::State;

/// A column at a height, as one that walks through everything meets it. Floors of a column are told
/// apart by whole metres and a half.
struct Spot {
  int x = 0;
  int y = 0;
  float height_m = 0.0F;

  std::tuple<int, int, int> key() const {
    return {x, y, static_cast<int>(std::floor(height_m / 1.5F))};
  }
};

struct SpotNote {
  float cost = std::numeric_limits<float>::infinity();
  Spot spot;
  std::tuple<int, int, int> parent;
  bool has_parent = false;
  bool is_done = false;
};

using Notes = std::map<std::tuple<int, int, int>, SpotNote>;

/// Looks at the plan as one that walks through everything.
class Obstruction {
 public:
  Obstruction(const NavigationGrid& grid, double radius_m) : grid_(grid), radius_m_(radius_m) {}

  /// In a tile of the plan or in one beside it.
  bool isNearPlan(const Spot& spot) const {
    const auto tile = places::computeTile({spot.x, spot.y});
    if (!grid_.plan().tilesAt(tile).empty()) return true;
    for (int i = 0; i < 9; ++i) {
      const places::GroundPlan::Index beside{tile.first + i % 3 - 1, tile.second + i / 3 - 1};
      if (!grid_.plan().tilesAt(beside).empty()) return true;
    }
    return false;
  }
  /// The cell on the floor that a spot is near to; null if it has none.
  const places::PlanCell* find(const Spot& spot) const {
    return grid_.plan().find({spot.x, spot.y}, static_cast<double>(spot.height_m), grid_.maxStep());
  }
  State findState(const Spot& spot) const {
    const places::PlanCell* cell = find(spot);
    return cell == nullptr ? State::kUnknown : cell->state;
  }
  bool hasRoom(const Spot& spot) const {
    const places::PlanCell* cell = find(spot);
    return cell != nullptr && cell->isFree() && static_cast<double>(cell->clearance_m) >= radius_m_;
  }
  float computeCost(const Spot& spot) const {
    if (hasRoom(spot)) return 1.0F;
    const State state = findState(spot);
    return state == State::kUnknown ? 3.0F : (state == State::kFree ? 4.0F : 30.0F);
  }
  Spot move(const Spot& from, int dx, int dy) const {
    Spot to{from.x + dx, from.y + dy, from.height_m};
    const places::PlanCell* cell = find(to);
    if (cell != nullptr) to.height_m = cell->floor_m;
    return to;
  }

 private:
  const NavigationGrid& grid_;
  double radius_m_;
};

std::vector<Spot> traceBack(const Notes& notes, const Spot& end) {
  std::vector<Spot> way;
  for (const SpotNote* note = &notes.at(end.key());; note = &notes.at(note->parent)) {
    way.push_back(note->spot);
    if (!note->has_parent) break;
  }
  std::reverse(way.begin(), way.end());
  return way;
}

/// The cheapest way through everything; empty if the tiles do not lead there.
std::vector<Spot> findCheapestWay(const Obstruction& obstruction, const Spot& start,
                                  const Spot& goal) {
  using Item = std::pair<float, std::tuple<int, int, int>>;
  std::priority_queue<Item, std::vector<Item>, std::greater<Item>> queue;
  Notes notes;
  notes[start.key()] = {0.0F, start, {}, false, false};
  queue.emplace(0.0F, start.key());
  while (!queue.empty()) {
    SpotNote& at = notes[queue.top().second];
    queue.pop();
    if (std::exchange(at.is_done, true)) continue;
    const bool is_near = std::abs(at.spot.height_m - goal.height_m) < 1.0F;
    if (at.spot.x == goal.x && at.spot.y == goal.y && is_near) return traceBack(notes, at.spot);
    for (const auto& [dx, dy] : {std::pair<int, int>{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const Spot next = obstruction.move(at.spot, dx, dy);
      if (!obstruction.isNearPlan(next)) continue;
      const float cost = at.cost + obstruction.computeCost(next);
      SpotNote& note = notes[next.key()];
      if (note.is_done || cost >= note.cost) continue;
      note = {cost, next, at.spot.key(), true, false};
      queue.emplace(cost, next.key());
    }
  }
  return {};
}

Blockage::Kind toKind(State state) {
  switch (state) {
    case State::kObstacle:
      return Blockage::Kind::kObstacle;
    case State::kUnknown:
      return Blockage::Kind::kUnknown;
    case State::kFree:
      break;
  }
  return Blockage::Kind::kNarrow;
}

/// Obstacles before unknown space before what is narrow.
int rank(Blockage::Kind kind) {
  return kind == Blockage::Kind::kObstacle ? 2 : (kind == Blockage::Kind::kUnknown ? 1 : 0);
}

/// Sets kind and position from the first stretch without room; false if there is none.
bool readFirstStretch(const Obstruction& obstruction, const NavigationGrid& grid,
                      const std::vector<Spot>& way, Blockage& blockage) {
  bool is_found = false;
  for (const Spot& spot : way) {
    if (obstruction.hasRoom(spot)) {
      if (is_found) break;
      continue;
    }
    const Blockage::Kind kind = toKind(obstruction.findState(spot));
    if (is_found && rank(kind) <= rank(blockage.kind)) continue;
    is_found = true;
    blockage.kind = kind;
    const Eigen::Vector2d center_m = grid.plan().computeCenter({spot.x, spot.y});
    blockage.position_m = {center_m.x(), center_m.y(), static_cast<double>(spot.height_m)};
  }
  return is_found;
}

/// Sets the position to the reached cell that is nearest to the goal, and tells which places are
/// reached.
std::vector<char> flood(const NavigationGrid& grid, const PlaceRouter& router, Node start,
                        const Eigen::Vector3d& goal_m, double radius_m, Blockage& blockage) {
  CellNotes<char> notes(grid);
  std::vector<Node> open{start};
  notes[start] = 1;
  double best_m = std::numeric_limits<double>::infinity();
  while (!open.empty()) {
    const Node at = open.back();
    open.pop_back();
    const double away_m = (grid.computePosition(at) - goal_m).norm();
    if (away_m < best_m) blockage.position_m = grid.computePosition(at);
    best_m = std::min(best_m, away_m);
    forEachMove(grid, at, radius_m, [&](int, int, Node next) {
      if (std::exchange(notes[next], 1) == 0) open.push_back(next);
    });
  }
  std::vector<char> is_reached(router.size(), 0);
  for (std::size_t place = 0; place < router.size(); ++place) {
    const Node node = grid.findFloor(router.position(place));
    is_reached[place] = node != NavigationGrid::kNone ? notes[node] : 0;
  }
  return is_reached;
}

}  // namespace

void setLastPlace(const PlaceRouter& router, const std::vector<char>& is_reached,
                  const Eigen::Vector3d& goal_m, Blockage& blockage) {
  double best_m = std::numeric_limits<double>::infinity();
  for (std::size_t place = 0; place < router.size(); ++place) {
    const double away_m = (router.position(place) - goal_m).norm();
    if (is_reached[place] == 0 || away_m >= best_m) continue;
    best_m = away_m;
    blockage.last_place = router.id(place);
    blockage.last_m = router.position(place);
  }
}

Blockage findBlockage(const NavigationGrid& grid, const PlaceRouter& router, Node start,
                      const Eigen::Vector3d& goal_m, double radius_m) {
  Blockage blockage;
  const auto is_reached = flood(grid, router, start, goal_m, radius_m, blockage);
  blockage.last_m = blockage.position_m;
  setLastPlace(router, is_reached, goal_m, blockage);
  const Obstruction obstruction(grid, radius_m);
  const auto index = grid.computeIndex(start);
  const Spot from{index.first, index.second, grid.cell(start).floor_m};
  const auto goal = grid.plan().computeCell(goal_m.head<2>());
  const Node floor = grid.findFloor(goal_m);
  const float height_m =
      floor == NavigationGrid::kNone ? static_cast<float>(goal_m.z()) : grid.cell(floor).floor_m;
  const auto way = findCheapestWay(obstruction, from, {goal.first, goal.second, height_m});
  if (!readFirstStretch(obstruction, grid, way, blockage)) blockage.kind = Blockage::Kind::kUnknown;
  return blockage;
}

}  // namespace tsg::planning
