// SPDX-License-Identifier: BSD-3-Clause
#include "space_map.h"

#include <algorithm>
#include <memory>

namespace tsg::places {
namespace {

bool isSame(const SpaceCell& a, const SpaceCell& b) {
  return a.offset == b.offset && a.is_free == b.is_free && a.is_axis == b.is_axis &&
         a.level_m == b.level_m && a.offset_m == b.offset_m;
}

PlanCell makePlanCell(const SpaceCell& cell) {
  return {cell.is_free ? PlanCell::State::kFree : PlanCell::State::kObstacle, cell.level_m,
          cell.clearance_m};
}

/// A floor's cells in a tile while it is being collected.
struct PlanTile {
  std::shared_ptr<GroundPlan::Tile> cells = std::make_shared<GroundPlan::Tile>();
  std::array<bool, kTileColumns> has{};

  /// True if a cell beside is at most a step away and this one is still empty.
  bool fits(const SpaceCell& cell, double max_step_m) const {
    if (has[cell.offset]) return false;
    const int x = cell.offset % kTileSide;
    const int y = cell.offset / kTileSide;
    for (const auto& [nx, ny] : {std::pair{x - 1, y}, {x, y - 1}, {x + 1, y - 1}, {x - 1, y - 1}}) {
      if (nx < 0 || ny < 0 || nx >= kTileSide) continue;
      const auto beside = static_cast<std::size_t>(nx + kTileSide * ny);
      const double rise_m = static_cast<double>((*cells)[beside].floor_m - cell.level_m);
      if (has[beside] && std::abs(rise_m) <= max_step_m) return true;
    }
    return false;
  }
  void set(const SpaceCell& cell) {
    has[cell.offset] = true;
    (*cells)[cell.offset] = makePlanCell(cell);
  }
};

}  // namespace

/// Puts cells in the place of a tile's. Clearances of cells that stay are kept.
bool SpaceMap::replace(const TileIndex& index, std::vector<SpaceCell> cells) {
  const auto found = tiles_.find(index);
  const bool is_new = found == tiles_.end();
  if (is_new && cells.empty()) return false;
  const bool is_same = !is_new && found->second.cells.size() == cells.size() &&
                       std::equal(cells.begin(), cells.end(), found->second.cells.begin(), isSame);
  if (is_same) return false;
  if (cells.empty()) {
    tiles_.erase(index);
    return true;
  }
  SpaceTile& tile = tiles_[index];
  tile.begin.fill(0);
  for (const SpaceCell& cell : cells) ++tile.begin[cell.offset + 1U];
  for (std::size_t i = 1; i < tile.begin.size(); ++i) tile.begin[i] += tile.begin[i - 1];
  tile.cells = std::move(cells);
  return true;
}

const SpaceCell* SpaceMap::findFree(const Column& column, double level_m,
                                    double tolerance_m) const {
  const SpaceTile* tile = find(computeTile(column));
  return tile == nullptr ? nullptr : findFree(*tile, column, level_m, tolerance_m);
}

const SpaceCell* SpaceMap::findFree(const SpaceTile& tile, const Column& column, double level_m,
                                    double tolerance_m) {
  const auto offset = static_cast<std::size_t>(computeOffset(column));
  const SpaceCell* best = nullptr;
  double best_m = tolerance_m;
  for (std::uint32_t i = tile.begin[offset]; i < tile.begin[offset + 1]; ++i) {
    const SpaceCell& cell = tile.cells[i];
    const double away_m = std::abs(static_cast<double>(cell.level_m) - level_m);
    if (!cell.is_free || away_m > best_m || (best != nullptr && away_m == best_m)) continue;
    best = &cell;
    best_m = away_m;
  }
  return best;
}

TileSet SpaceMap::updateVoronoi(const TileSet& changed) {
  TileSet result;
  for (const TileIndex& index : widen(changed, 1)) {
    if (markVoronoi(index)) result.insert(index);
  }
  return result;
}

bool SpaceMap::markVoronoi(const TileIndex& index) {
  const auto tile = tiles_.find(index);
  if (tile == tiles_.end()) return false;
  const TilesAround<SpaceTile> around(tiles_, index);
  bool is_changed = false;
  for (SpaceCell& cell : tile->second.cells) {
    if (!cell.is_free) continue;
    const bool is_voronoi = isVoronoi(around, computeColumn(index, cell.offset), cell);
    is_changed = is_changed || cell.is_voronoi != is_voronoi;
    cell.is_voronoi = is_voronoi;
  }
  return is_changed;
}

bool SpaceMap::isVoronoi(const TilesAround<SpaceTile>& around, const Column& column,
                         const SpaceCell& cell) const {
  const auto is_open = [&](const SpaceCell* other) {
    return other != nullptr && other->has_parent &&
           static_cast<double>(other->clearance_m) >= config_.min_clearance_m;
  };
  if (!is_open(&cell)) return false;
  const double level_m = static_cast<double>(cell.level_m);
  const auto findOther = [&](const Column& at, double at_m, double tolerance_m) {
    const SpaceTile* tile = around.find(at);
    return tile == nullptr ? nullptr : findFree(*tile, at, at_m, tolerance_m);
  };
  for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {-1, 0}, {0, -1}}) {
    const Column beside{column.x + dx, column.y + dy};
    const double tolerance_m = isPlan() ? config_.max_step_m : 0.5 * voxel_size_m_;
    const SpaceCell* other = findOther(beside, level_m, tolerance_m);
    if (!is_open(other)) continue;
    const bool is_first = dx + dy > 0;
    if (is_first ? hasDistinctParents(column, cell, *other)
                 : hasDistinctParents(beside, *other, cell))
      return true;
  }
  if (isPlan()) return false;
  for (const double dz_m : {voxel_size_m_, -voxel_size_m_}) {
    const SpaceCell* other = findOther(column, level_m + dz_m, 0.5 * voxel_size_m_);
    if (!is_open(other)) continue;
    if (dz_m > 0.0 ? hasDistinctParents(column, cell, *other)
                   : hasDistinctParents(column, *other, cell))
      return true;
  }
  return false;
}

/// True if two neighbouring cells have nearest obstacles on different sides, as seen from the
/// first.
bool SpaceMap::hasDistinctParents(const Column& column, const SpaceCell& cell,
                                  const SpaceCell& neighbour) const {
  if (cell.parent == neighbour.parent) return false;
  const int z =
      isPlan() ? 0
               : static_cast<int>(std::floor(static_cast<double>(cell.level_m) / voxel_size_m_));
  const GridIndex at(column.x, column.y, z);
  const GridIndex to_parent = cell.parent - at;
  const GridIndex to_other = neighbour.parent - at;
  const double separation_m = (to_parent - to_other).cwiseAbs().sum() * voxel_size_m_;
  if (separation_m > config_.min_parent_separation_m) return true;
  const double cosine =
      to_parent.cast<double>().normalized().dot(to_other.cast<double>().normalized());
  return cosine < config_.max_parent_cosine;
}

/// Cells that hang together over steps make a floor; a second cell of a column begins another.
std::vector<GroundPlan::TilePtr> SpaceMap::makePlanTiles(const TileIndex& index) const {
  std::vector<PlanTile> tiles;
  const SpaceTile* tile = find(index);
  if (tile != nullptr) {
    for (const SpaceCell& cell : tile->cells) {
      const auto fits = [&](const PlanTile& plan) { return plan.fits(cell, config_.max_step_m); };
      auto found = std::find_if(tiles.begin(), tiles.end(), fits);
      if (found == tiles.end()) {
        found = std::find_if(tiles.begin(), tiles.end(),
                             [&](const PlanTile& plan) { return !plan.has[cell.offset]; });
      }
      if (found == tiles.end()) found = tiles.emplace(tiles.end());
      found->set(cell);
    }
  }
  std::vector<GroundPlan::TilePtr> result;
  for (PlanTile& plan : tiles) result.push_back(std::move(plan.cells));
  return result;
}

FreeLine followLine(const SpaceMap& space, const GridIndex& from, double from_level_m,
                    const GridIndex& to, double to_level_m, double min_clearance_m) {
  const bool is_plan = space.isPlan();
  GridIndex step = to - from;
  if (is_plan) step.z() = 0;
  const int samples = 2 * step.cwiseAbs().maxCoeff() + 1;
  const double per_sample = 1.0 / samples;
  const auto at = [&](int axis, int sample) {
    return static_cast<int>(std::floor(from[axis] + step[axis] * (sample * per_sample) + 0.5));
  };
  FreeLine line{true, 1e9};
  double level_m = from_level_m;
  const double tolerance_m = is_plan ? space.maxStep() : 0.5 * space.voxelSize();
  Column last{from.x() - 1, from.y()};
  TileIndex tile_index = computeTile(Column{from.x(), from.y()});
  const SpaceTile* tile = space.find(tile_index);
  for (int i = 0; i <= samples; ++i) {
    const Column column{at(0, i), at(1, i)};
    if (is_plan && column.x == last.x && column.y == last.y) continue;
    last = column;
    if (!is_plan) level_m = (at(2, i) + 0.5) * space.voxelSize();
    if (computeTile(last) != tile_index) {
      tile_index = computeTile(last);
      tile = space.find(tile_index);
    }
    if (tile == nullptr) return {};
    const SpaceCell* cell = SpaceMap::findFree(*tile, last, level_m, tolerance_m);
    if (cell == nullptr || static_cast<double>(cell->clearance_m) < min_clearance_m) return {};
    level_m = static_cast<double>(cell->level_m);
    line.clearance_m = std::min(line.clearance_m, static_cast<double>(cell->clearance_m));
  }
  if (std::abs(level_m - to_level_m) > tolerance_m) return {};
  return line;
}

}  // namespace tsg::places
