// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "floor_map.h"
#include "task_scene_graph/places/ground_plan.h"
#include "task_scene_graph/places/places_config.h"
#include "task_scene_graph/places/voxel_map.h"
#include "tiles.h"
#include "way_map.h"

namespace tsg::places {

/// A cell of free space, or an obstacle. Of a ground plan: a column of voxels at the height of one
/// floor; of a volume: a voxel.
struct SpaceCell {
  std::uint8_t offset = 0;  ///< of the column in its tile
  bool is_free = false;     ///< else an obstacle
  bool is_axis = false;     ///< the middle of the body was here
  bool is_voronoi = false;
  bool has_parent = false;
  float level_m = 0.0F;      ///< plan: world z of the floor; volume: of the voxel's centre
  float offset_m = 0.0F;     ///< of an obstacle: its signed distance, at most half a voxel diagonal
  float clearance_m = 0.0F;  ///< of a free cell: to the nearest obstacle, at most the limit
  GridIndex parent = GridIndex::Zero();  ///< that obstacle's column (z = 0), or voxel
};

/// Cells along which nothing may be cut: the way of the body and the Voronoi diagram.
inline bool isTrace(const SpaceCell& cell) { return cell.is_axis || cell.is_voronoi; }

/// The cells of 8 x 8 columns by column, then by level.
struct SpaceTile {
  std::array<std::uint32_t, kTileColumns + 1> begin{};
  std::vector<SpaceCell> cells;
  double reach_m = -1.0;  ///< obstacles farther than this from the tile change none of its cells
};

/// Observed free space and obstacles, sparse. What is free and what an obstacle is read from floors
/// and voxels (updateCells()), clearances by updateClearance(); each is a function of the map
/// alone, so the result of updates is that of a computation from scratch.
///
/// Clearance: the distance d between the centres of a cell and the nearest obstacle cell (ties: the
/// lowest y, then x, of a volume z first) plus that obstacle's signed distance, clamped to
/// [0, max_distance_m]. Of a ground plan d is horizontal and obstacles count whose level lies in
/// the same or a neighbouring slab of half a body's height, so that storeys do not mix and stairs
/// have their walls.
class SpaceMap {
 public:
  explicit SpaceMap(const PlacesConfig& config) : config_(config) {}

  /// Reads the cells of tiles whose floor or voxels changed, and of the plan those around them.
  /// @returns the tiles whose cells differ from before.
  /// @param seen  tiles whose voxels changed
  /// @param with_floor  tiles whose floor changed
  TileSet updateCells(const VoxelMap& voxels, const FloorMap& floors, const TileSet& seen,
                      const TileSet& with_floor);
  TileSet updateCells(const VoxelMap& voxels, const WayMap& way, const TileSet& changed);

  /// Clearances around tiles whose cells changed. @returns the tiles in which any cell differs.
  TileSet updateClearance(const TileSet& changed);

  /// Marks the cells of the generalised Voronoi diagram: free, clearance >= min_clearance_m, and
  /// beside a free cell with such clearance whose nearest obstacle is a different one (see
  /// min_parent_separation_m, max_parent_cosine). @returns the tiles in which a mark changed.
  TileSet updateVoronoi(const TileSet& changed);

  double voxelSize() const { return voxel_size_m_; }
  bool isPlan() const { return config_.free_space == FreeSpaceKind::kWalkable; }
  const SpaceTile* find(const TileIndex& index) const {
    const auto found = tiles_.find(index);
    return found == tiles_.end() ? nullptr : &found->second;
  }

  /// The free cell of a column whose level is nearest, at most `tolerance_m` away; else null.
  const SpaceCell* findFree(const Column& column, double level_m, double tolerance_m) const;
  /// Of a column in this tile.
  static const SpaceCell* findFree(const SpaceTile& tile, const Column& column, double level_m,
                                   double tolerance_m);
  /// Calls `visit(cell)` for the free cells of a column in which the middle of the body was, at
  /// most `tolerance_m` away.
  template <typename Visit>
  void forEachAxis(const Column& column, double level_m, double tolerance_m, Visit visit) const {
    const SpaceTile* tile = find(computeTile(column));
    if (tile == nullptr) return;
    const auto offset = static_cast<std::size_t>(computeOffset(column));
    for (std::uint32_t i = tile->begin[offset]; i < tile->begin[offset + 1]; ++i) {
      const SpaceCell& cell = tile->cells[i];
      const double away_m = std::abs(static_cast<double>(cell.level_m) - level_m);
      if (cell.is_free && cell.is_axis && away_m <= tolerance_m) visit(cell);
    }
  }
  /// How far the levels of neighbouring cells may differ.
  double maxStep() const { return isPlan() ? config_.max_step_m : 1.5 * voxel_size_m_; }

  /// The cells of a tile as tiles of a plan, one for each floor there.
  std::vector<GroundPlan::TilePtr> makePlanTiles(const TileIndex& index) const;

 private:
  /// Cells of a box whose clearance is exact, though only obstacles in the margin were looked at.
  bool computeBox(const TileBox& box, double margin_m, TileSet& result);
  bool replace(const TileIndex& index, std::vector<SpaceCell> cells);
  TileSet findAffected(const TileSet& changed) const;
  bool markVoronoi(const TileIndex& index);
  bool isVoronoi(const TilesAround<SpaceTile>& around, const Column& column,
                 const SpaceCell& cell) const;
  bool hasDistinctParents(const Column& column, const SpaceCell& cell,
                          const SpaceCell& neighbour) const;

  PlacesConfig config_;
  double voxel_size_m_ = 0.0;
  std::unordered_map<TileIndex, SpaceTile, TileIndexHash> tiles_;
};

/// A straight line between free cells.
struct FreeLine {
  bool is_free = false;
  double clearance_m = 0.0;  ///< smallest of the cells on it
};

/// Follows the floor from column to column (`volume`: the straight line), as far as there is
/// `min_clearance_m`.
FreeLine followLine(const SpaceMap& space, const GridIndex& from, double from_level_m,
                    const GridIndex& to, double to_level_m, double min_clearance_m = 0.0);

}  // namespace tsg::places
