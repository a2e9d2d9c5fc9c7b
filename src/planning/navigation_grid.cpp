// SPDX-License-Identifier: BSD-3-Clause
#include "navigation_grid.h"

#include <algorithm>
#include <cmath>

namespace tsg::planning {
namespace {

constexpr int kSide = places::GroundPlan::kTileSide;

/// Of a cell, in cells: clearance in it differs by no more from that of its centre.
constexpr double kHalfDiagonal = 0.70711;

/// 0, 1 or 2: before, in or behind a tile.
int findSide(int local) { return local < 0 ? 0 : (local < kSide ? 1 : 2); }

}  // namespace

NavigationGrid::NavigationGrid(places::GroundPlan plan, double max_step_m)
    : plan_(std::move(plan)), max_step_m_(max_step_m) {
  for (const auto& [index, floors] : plan_.tiles()) {
    for (const auto& tile : floors) {
      tiles_.emplace_back();
      tiles_.back().cells = tile.get();
      tiles_.back().index = index;
    }
  }
  linkTiles();
}

void NavigationGrid::linkTiles() {
  // Positions are sorted, and so are those of the neighbours in one direction: one sweep for each.
  for (std::size_t side = 0; side < 9; ++side) {
    const int dx = static_cast<int>(side % 3) - 1;
    const int dy = static_cast<int>(side / 3) - 1;
    std::size_t at = 0;
    for (TileEntry& tile : tiles_) {
      const Index wanted{tile.index.first + dx, tile.index.second + dy};
      while (at < tiles_.size() && tiles_[at].index < wanted) ++at;
      tile.first[side] = static_cast<std::uint32_t>(at);
      std::size_t end = at;
      while (end < tiles_.size() && tiles_[end].index == wanted) ++end;
      tile.count[side] = static_cast<std::uint8_t>(std::min<std::size_t>(end - at, 255));
    }
  }
}

NavigationGrid::Index NavigationGrid::computeIndex(Node node) const {
  const Index& tile = tiles_[node / kTileCells].index;
  const int offset = static_cast<int>(node % kTileCells);
  return {tile.first * kSide + offset % kSide, tile.second * kSide + offset / kSide};
}

Eigen::Vector3d NavigationGrid::computePosition(Node node) const {
  const Eigen::Vector2d center_m = computeCenter(node);
  return {center_m.x(), center_m.y(), static_cast<double>(cell(node).floor_m)};
}

NavigationGrid::Node NavigationGrid::findNeighbour(Node from, int dx, int dy) const {
  const TileEntry& tile = tiles_[from / kTileCells];
  const int offset = static_cast<int>(from % kTileCells);
  const int x = offset % kSide + dx;
  const int y = offset / kSide + dy;
  const auto side = static_cast<std::size_t>(findSide(x) + 3 * findSide(y));
  const auto local = static_cast<std::uint32_t>((x & (kSide - 1)) + kSide * (y & (kSide - 1)));
  const float floor_m = cell(from).floor_m;
  const auto max_step_m = static_cast<float>(max_step_m_);
  if (tile.count[side] == 1) {
    const Node node = tile.first[side] * kTileCells + local;
    return std::abs(cell(node).floor_m - floor_m) <= max_step_m ? node : kNone;
  }
  Node best = kNone;
  float best_m = max_step_m;
  for (std::uint32_t i = 0; i < tile.count[side]; ++i) {
    const Node node = (tile.first[side] + i) * kTileCells + local;
    const float away_m = std::abs(cell(node).floor_m - floor_m);
    if (!(away_m <= best_m) || (best != kNone && away_m == best_m)) continue;
    best = node;
    best_m = away_m;
  }
  return best;
}

NavigationGrid::Node NavigationGrid::findFloor(const Eigen::Vector3d& p_m) const {
  const Index index = plan_.computeCell(p_m.head<2>());
  const Index tile = places::computeTile(index);
  const auto offset = static_cast<std::uint32_t>(places::computeOffset(index));
  auto at = std::lower_bound(tiles_.begin(), tiles_.end(), tile,
                             [](const TileEntry& a, const Index& b) { return a.index < b; });
  const auto limit_m = static_cast<float>(p_m.z() + max_step_m_);
  Node below = kNone;
  Node lowest = kNone;
  for (; at != tiles_.end() && at->index == tile; ++at) {
    const float floor_m = (*at->cells)[offset].floor_m;
    if (std::isnan(floor_m)) continue;
    const auto node = static_cast<Node>(at - tiles_.begin()) * kTileCells + offset;
    if (lowest == kNone || floor_m < cell(lowest).floor_m) lowest = node;
    if (floor_m > limit_m) continue;
    if (below == kNone || floor_m > cell(below).floor_m) below = node;
  }
  return below != kNone ? below : lowest;
}

double NavigationGrid::computeClearance(Node node, const Eigen::Vector2d& p_m) const {
  const Eigen::Vector2d away = (p_m - computeCenter(node)) / cellSize();
  const int dx = away.x() < 0.0 ? -1 : 1;
  const int dy = away.y() < 0.0 ? -1 : 1;
  const auto own_m = static_cast<double>(cell(node).clearance_m);
  const auto read = [&](int x, int y) {
    const Node at = findNeighbour(node, x, y);
    if (at == kNone || cell(at).state == places::PlanCell::State::kUnknown) return own_m;
    return cell(at).isFree() ? static_cast<double>(cell(at).clearance_m) : 0.0;
  };
  const double u = std::min(1.0, std::abs(away.x()));
  const double v = std::min(1.0, std::abs(away.y()));
  if (u < 1e-9 && v < 1e-9) return own_m;
  return (1.0 - v) * ((1.0 - u) * own_m + u * read(dx, 0)) +
         v * ((1.0 - u) * read(0, dy) + u * read(dx, dy));
}

bool NavigationGrid::isClear(Node node, const Eigen::Vector2d& p_m, double radius_m) const {
  if (!cell(node).isFree()) return false;
  if (static_cast<double>(cell(node).clearance_m) >= radius_m + kHalfDiagonal * cellSize()) {
    return true;
  }
  return computeClearance(node, p_m) >= radius_m - 1e-6;
}

NavigationGrid::Node NavigationGrid::walk(Node from, const Eigen::Vector2d& a_m,
                                          const Eigen::Vector2d& b_m, double radius_m) const {
  const double steps = std::ceil(2.0 * (b_m - a_m).norm() / cellSize());
  const double wide_m = radius_m + kHalfDiagonal * cellSize();
  const Eigen::Vector2d a = a_m / cellSize();
  const Eigen::Vector2d along = (b_m - a_m) / cellSize();
  Node node = from;
  Index index = computeIndex(from);
  for (double i = 1.0; i <= steps; i += 1.0) {
    // In cells. From one sample to the next there is at most one cell in each direction.
    const double x = a.x() + along.x() * (i / steps) - index.first;
    const double y = a.y() + along.y() * (i / steps) - index.second;
    const int dx = x < 0.0 ? -1 : (x < 1.0 ? 0 : 1);
    const int dy = y < 0.0 ? -1 : (y < 1.0 ? 0 : 1);
    if (dx != 0 || dy != 0) {
      node = findNeighbour(node, dx, dy);
      if (node == kNone) return kNone;
      index = {index.first + dx, index.second + dy};
    }
    const places::PlanCell& at = cell(node);
    if (at.isFree() && static_cast<double>(at.clearance_m) >= wide_m) continue;
    if (!isClear(node, a_m + (b_m - a_m) * (i / steps), radius_m)) return kNone;
  }
  return node;
}

}  // namespace tsg::planning
