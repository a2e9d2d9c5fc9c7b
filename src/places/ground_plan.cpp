// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/places/ground_plan.h"

#include <cmath>

namespace tsg::places {
namespace {

bool isSame(float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }

}  // namespace

int divideFloor(int value, int divisor) {
  return value >= 0 ? value / divisor : -((divisor - 1 - value) / divisor);
}

bool operator==(const PlanCell& a, const PlanCell& b) {
  return a.state == b.state && isSame(a.floor_m, b.floor_m) && isSame(a.clearance_m, b.clearance_m);
}

GroundPlan::Index computeTile(const GroundPlan::Index& cell) {
  return {divideFloor(cell.first, GroundPlan::kTileSide),
          divideFloor(cell.second, GroundPlan::kTileSide)};
}

std::size_t computeOffset(const GroundPlan::Index& cell) {
  const GroundPlan::Index tile = computeTile(cell);
  const int x = cell.first - tile.first * GroundPlan::kTileSide;
  const int y = cell.second - tile.second * GroundPlan::kTileSide;
  return static_cast<std::size_t>(x + GroundPlan::kTileSide * y);
}

void GroundPlan::setTiles(const Index& tile, std::vector<TilePtr> tiles) {
  if (tiles.empty()) {
    tiles_.erase(tile);
  } else {
    tiles_[tile] = std::move(tiles);
  }
}

const std::vector<GroundPlan::TilePtr>& GroundPlan::tilesAt(const Index& tile) const {
  static const std::vector<TilePtr> kNone;
  const auto found = tiles_.find(tile);
  return found == tiles_.end() ? kNone : found->second;
}

const PlanCell* GroundPlan::find(const Index& cell, double floor_m, double max_step_m) const {
  const std::size_t offset = computeOffset(cell);
  const PlanCell* best = nullptr;
  double best_m = max_step_m;
  for (const TilePtr& tile : tilesAt(computeTile(cell))) {
    const PlanCell& candidate = (*tile)[offset];
    const double away_m = std::abs(static_cast<double>(candidate.floor_m) - floor_m);
    if (!(away_m <= best_m) || (best != nullptr && away_m == best_m)) continue;
    best = &candidate;
    best_m = away_m;
  }
  return best;
}

GroundPlan::Index GroundPlan::computeCell(const Eigen::Vector2d& p_m) const {
  return {static_cast<int>(std::floor(p_m.x() / cell_size_m_)),
          static_cast<int>(std::floor(p_m.y() / cell_size_m_))};
}

Eigen::Vector2d GroundPlan::computeCenter(const Index& cell) const {
  return cell_size_m_ * Eigen::Vector2d(cell.first + 0.5, cell.second + 0.5);
}

}  // namespace tsg::places
