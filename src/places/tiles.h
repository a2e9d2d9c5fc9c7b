// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <set>
#include <vector>

#include "task_scene_graph/places/dense_grid.h"
#include "task_scene_graph/places/voxel_map.h"

namespace tsg::places {

/// Tiles of 8 x 8 columns of voxels: the columns of a block column.
using TileIndex = VoxelMap::ColumnIndex;
using TileSet = std::set<TileIndex>;

constexpr int kTileSide = mapping::kBlockSide;
constexpr int kTileColumns = kTileSide * kTileSide;

struct TileIndexHash {
  std::size_t operator()(const TileIndex& index) const {
    return mapping::GridIndexHash{}({index.first, index.second, 0});
  }
};

/// A column of voxels, by its x and y index.
struct Column {
  int x = 0;
  int y = 0;
};

inline TileIndex computeTile(const Column& column) { return {column.x >> 3, column.y >> 3}; }
/// Place of a column in its tile, x fastest.
inline int computeOffset(const Column& column) {
  return (column.x & 7) + kTileSide * (column.y & 7);
}
inline Column computeColumn(const TileIndex& tile, int offset) {
  return {tile.first * kTileSide + offset % kTileSide,
          tile.second * kTileSide + offset / kTileSide};
}

/// A tile and those that touch it, looked up once. Valid until one of them comes or goes.
template <typename Tile>
class TilesAround {
 public:
  /// @param tiles  a map by TileIndex
  template <typename Tiles>
  TilesAround(const Tiles& tiles, const TileIndex& middle)
      : first_(middle.first - 1, middle.second - 1) {
    for (std::size_t i = 0; i < found_.size(); ++i) {
      const auto step = static_cast<int>(i);
      const auto found = tiles.find({first_.first + step % 3, first_.second + step / 3});
      found_[i] = found == tiles.end() ? nullptr : &found->second;
    }
  }

  /// Null if there is none. Precondition: the column lies in one of the nine.
  const Tile* find(const Column& column) const {
    const TileIndex index = computeTile(column);
    return found_[static_cast<std::size_t>(index.first - first_.first +
                                           3 * (index.second - first_.second))];
  }

 private:
  TileIndex first_;
  std::array<const Tile*, 9> found_{};
};

/// Rounds to sixteenths of a voxel, so that nothing follows from noise below that.
inline float roundToStep(float value_m, double voxel_size_m) {
  const auto step_m = static_cast<float>(voxel_size_m / 16.0);
  return step_m * std::round(value_m / step_m);
}

/// Adds all tiles at most `rings` away (along x or y). O(tiles rings log).
TileSet widen(const TileSet& tiles, int rings);

/// A box of tiles to be computed together, with those of its tiles that are wanted.
struct TileBox {
  TileIndex min;
  TileIndex max;  ///< included
  std::vector<TileIndex> tiles;
};

/// Covers tiles by boxes of at most 20 tiles (16 m at 0.1 m) a side: islands that lie apart,
/// divided where they are larger, so that dense grids follow what changed, not how far apart it
/// lies.
std::vector<TileBox> coverByBoxes(const TileSet& tiles);

/// The ground plan (size z = 1) of a box and `margin` columns around it.
GridExtent computeExtent(const TileBox& box, int margin);

}  // namespace tsg::places
