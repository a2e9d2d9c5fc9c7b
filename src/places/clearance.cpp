// SPDX-License-Identifier: BSD-3-Clause
// Distances from free cells to obstacles.
#include <algorithm>
#include <cmath>
#include <map>

#include "space_map.h"

namespace tsg::places {
namespace {

/// Obstacles are first looked for this near; rarely is one farther away.
constexpr double kFirstMargin_m = 2.0;

/// Height of the slabs of a volume, in voxels.
constexpr int kVolumeSlab = 64;

/// Obstacles of one slab and its neighbours in a dense box.
struct Slab {
  GridExtent extent;
  std::vector<char> is_obstacle;
  std::vector<float> offset_m;
  NearestField nearest;

  void add(std::size_t cell, float cell_offset_m) {
    // of several in a column (neighbouring slabs) the one nearest to its surface
    const bool is_first = is_obstacle[cell] == 0;
    offset_m[cell] = is_first ? cell_offset_m : std::max(offset_m[cell], cell_offset_m);
    is_obstacle[cell] = 1;
  }
};

/// Smallest distance between two tiles, edge to edge, in tiles; squared.
int computeSquaredGap(const TileIndex& a, const TileIndex& b) {
  const int dx = std::max(0, std::abs(a.first - b.first) - 1);
  const int dy = std::max(0, std::abs(a.second - b.second) - 1);
  return dx * dx + dy * dy;
}

}  // namespace

/// Dense distance fields of a box, one for each slab that has free cells there.
class ClearanceBox {
 public:
  ClearanceBox(const SpaceMap& space, const PlacesConfig& config, const TileBox& box,
               double margin_m)
      : space_(space),
        is_plan_(space.isPlan()),
        slab_m_(std::max(config.body_height_m / 2.0, 2.0 * config.max_step_m)),
        margin_cells_(static_cast<int>(std::ceil(margin_m / space.voxelSize()))),
        extent_(computeExtent(box, margin_cells_)) {
    for (const TileIndex& index : box.tiles) prepare(index);
    const int rings = (margin_cells_ + kTileSide - 1) / kTileSide;
    for (int y = box.min.second - rings; y <= box.max.second + rings; ++y) {
      for (int x = box.min.first - rings; x <= box.max.first + rings; ++x) add({x, y});
    }
    const double max_cells = std::min<double>(margin_cells_, config.max_distance_m / voxelSize());
    for (auto& [key, slab] : slabs_) {
      slab.nearest = computeNearestField(slab.extent, slab.is_obstacle, max_cells);
    }
  }

  /// @returns the distance of centres, in cells; negative if no obstacle is in the margin
  double compute(const Column& column, SpaceCell& cell, double max_distance_m) const {
    const Slab& slab = slabs_.at(computeSlab(cell));
    const std::size_t at = slab.extent.toLinear(toIndex(column, cell));
    const std::int32_t source = slab.nearest.source[at];
    cell.has_parent = source != NearestField::kNone;
    cell.clearance_m = static_cast<float>(max_distance_m);
    cell.parent.setZero();
    if (!cell.has_parent) return -1.0;
    const auto parent = static_cast<std::size_t>(source);
    cell.parent = slab.extent.toIndex(parent);
    const double cells = std::sqrt(static_cast<double>(slab.nearest.squared_cells[at]));
    const double clearance_m = cells * voxelSize() + static_cast<double>(slab.offset_m[parent]);
    cell.clearance_m = static_cast<float>(std::clamp(clearance_m, 0.0, max_distance_m));
    return cells;
  }

 private:
  double voxelSize() const { return space_.voxelSize(); }

  /// Of a volume slab k holds voxels [k - 1/2, k + 1/2) * kVolumeSlab.
  int computeVolumeSlab(int z) const {
    return static_cast<int>(std::floor((z + 0.5 * kVolumeSlab) / kVolumeSlab));
  }

  int computeSlab(const SpaceCell& cell) const {
    if (!is_plan_) return computeVolumeSlab(toIndex({}, cell).z());
    return static_cast<int>(std::lround(static_cast<double>(cell.level_m) / slab_m_));
  }

  GridIndex toIndex(const Column& column, const SpaceCell& cell) const {
    const double z = std::floor(static_cast<double>(cell.level_m) / voxelSize());
    return {column.x, column.y, is_plan_ ? 0 : static_cast<int>(z)};
  }

  GridExtent computeSlabExtent(int key) const {
    GridExtent extent = extent_;
    if (is_plan_) return extent;
    extent.min.z() = key * kVolumeSlab - kVolumeSlab / 2 - margin_cells_;
    extent.size.z() = kVolumeSlab + 2 * margin_cells_;
    return extent;
  }

  void prepare(const TileIndex& index) {
    const SpaceTile* tile = space_.find(index);
    if (tile == nullptr) return;
    for (const SpaceCell& cell : tile->cells) {
      if (!cell.is_free) continue;
      Slab& slab = slabs_[computeSlab(cell)];
      if (!slab.is_obstacle.empty()) continue;
      slab.extent = computeSlabExtent(computeSlab(cell));
      slab.is_obstacle.assign(slab.extent.numCells(), 0);
      slab.offset_m.assign(slab.extent.numCells(), 0.0F);
    }
  }

  void add(const TileIndex& index) {
    const SpaceTile* tile = space_.find(index);
    if (tile == nullptr) return;
    for (const SpaceCell& cell : tile->cells) {
      if (cell.is_free) continue;
      const GridIndex at = toIndex(computeColumn(index, cell.offset), cell);
      const int key = computeSlab(cell);
      const int first = is_plan_ ? key - 1 : computeVolumeSlab(at.z() - margin_cells_);
      const int last = is_plan_ ? key + 1 : computeVolumeSlab(at.z() + margin_cells_);
      for (auto slab = slabs_.lower_bound(first); slab != slabs_.end() && slab->first <= last;
           ++slab) {
        const GridExtent& extent = slab->second.extent;
        if (extent.contains(at)) slab->second.add(extent.toLinear(at), cell.offset_m);
      }
    }
  }

  const SpaceMap& space_;
  bool is_plan_;
  double slab_m_;
  int margin_cells_;
  GridExtent extent_;
  std::map<int, Slab> slabs_;
};

TileSet SpaceMap::updateClearance(const TileSet& changed) {
  TileSet result;
  for (const TileBox& box : coverByBoxes(findAffected(changed))) {
    const double first_m = std::min(kFirstMargin_m, config_.max_distance_m);
    if (computeBox(box, first_m, result)) continue;
    computeBox(box, config_.max_distance_m, result);
  }
  result.insert(changed.begin(), changed.end());
  return result;
}

/// Tiles that changed, and those with a cell that has no obstacle nearer than one of these tiles.
TileSet SpaceMap::findAffected(const TileSet& changed) const {
  const double tile_m = kTileSide * voxel_size_m_;
  const auto rings = 1 + static_cast<int>(std::ceil(config_.max_distance_m / tile_m));
  TileSet affected;
  for (const TileIndex& index : changed) {
    if (find(index) != nullptr) affected.insert(index);
  }
  for (const TileBox& box : coverByBoxes(changed)) {
    for (int x = box.min.first - rings; x <= box.max.first + rings; ++x) {
      for (int y = box.min.second - rings; y <= box.max.second + rings; ++y) {
        const SpaceTile* tile = find({x, y});
        if (tile == nullptr || tile->reach_m < 0.0) continue;
        const double reach_tiles = tile->reach_m / tile_m;
        const bool is_reached =
            std::any_of(box.tiles.begin(), box.tiles.end(), [&](const TileIndex& index) {
              return computeSquaredGap(index, {x, y}) <= reach_tiles * reach_tiles;
            });
        if (is_reached) affected.insert({x, y});
      }
    }
  }
  return affected;
}

bool SpaceMap::computeBox(const TileBox& box, double margin_m, TileSet& result) {
  const ClearanceBox field(*this, config_, box, margin_m);
  const bool is_last = margin_m >= config_.max_distance_m;
  bool is_complete = true;
  for (const TileIndex& index : box.tiles) {
    const auto found = tiles_.find(index);
    if (found == tiles_.end()) continue;
    SpaceTile& tile = found->second;
    tile.reach_m = -1.0;
    for (SpaceCell& cell : tile.cells) {
      if (!cell.is_free) continue;
      const SpaceCell before = cell;
      const double cells =
          field.compute(computeColumn(index, cell.offset), cell, config_.max_distance_m);
      if (cells < 0.0 && !is_last) is_complete = false;
      const double reach_m = cells < 0.0 ? config_.max_distance_m : cells * voxel_size_m_;
      tile.reach_m = std::max(tile.reach_m, reach_m);
      if (cell.clearance_m != before.clearance_m || cell.parent != before.parent ||
          cell.has_parent != before.has_parent) {
        result.insert(index);
      }
    }
  }
  return is_complete;
}

}  // namespace tsg::places
