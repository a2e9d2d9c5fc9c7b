// SPDX-License-Identifier: BSD-3-Clause
// What is free and what is an obstacle.
#include <algorithm>
#include <cmath>
#include <map>

#include "space_map.h"

namespace tsg::places {
namespace {

/// Obstacles farther than this from all floor are none of it.
constexpr double kObstacleReach_m = 2.0;

/// Height of the slabs in which floors are looked at apart.
double computeSlabHeight(const PlacesConfig& config) {
  return std::max(config.body_height_m / 2.0, 2.0 * config.max_step_m);
}

/// An obstacle voxel's centre lies at most this far inside the surface.
float clampOffset(float distance_m, double voxel_size_m) {
  const auto deepest_m = static_cast<float>(-0.5 * std::sqrt(3.0) * voxel_size_m);
  return std::clamp(roundToStep(distance_m, voxel_size_m), deepest_m, 0.0F);
}

/// The nearest floor of each column of a box, slab by slab.
class NearestFloor {
 public:
  NearestFloor(const FloorMap& floors, const PlacesConfig& config, const TileBox& box,
               double voxel_size_m)
      : voxel_size_m_(voxel_size_m),
        extent_(computeExtent(box, computeMargin(voxel_size_m))),
        slab_m_(computeSlabHeight(config)) {
    const int rings = (computeMargin(voxel_size_m) + kTileSide - 1) / kTileSide;
    for (int x = box.min.first - rings; x <= box.max.first + rings; ++x) {
      for (int y = box.min.second - rings; y <= box.max.second + rings; ++y) {
        floors.forEachFloor({x, y}, [&](const GroundNode& node) {
          const Column column = computeColumn({x, y}, node.offset);
          const GridIndex at(column.x, column.y, 0);
          if (extent_.contains(at)) add(extent_.toLinear(at), node);
        });
      }
    }
    for (auto& [key, slab] : slabs_) {
      slab.nearest = computeNearestField(extent_, slab.is_floor, computeMargin(voxel_size_m));
    }
  }

  struct Candidate {
    double distance_m = 0.0;
    int slab = 0;
    float height_m = 0.0F;
    bool is_ramp = false;
  };

  /// Floors within reach of a column, one of each slab, nearest first.
  void find(const Column& column, std::vector<Candidate>& found) const {
    found.clear();
    const std::size_t cell = extent_.toLinear({column.x, column.y, 0});
    for (const auto& [key, slab] : slabs_) {
      const std::int32_t source = slab.nearest.source[cell];
      if (source == NearestField::kNone) continue;
      const auto at = static_cast<std::size_t>(source);
      const double cells = std::sqrt(static_cast<double>(slab.nearest.squared_cells[cell]));
      found.push_back({cells * voxel_size_m_, key, slab.height_m[at], slab.is_ramp[at] != 0});
    }
    std::sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) {
      return a.distance_m == b.distance_m ? a.slab < b.slab : a.distance_m < b.distance_m;
    });
  }

 private:
  struct Slab {
    std::vector<char> is_floor;
    std::vector<float> height_m;
    std::vector<char> is_ramp;
    NearestField nearest;
  };

  static int computeMargin(double voxel_size_m) {
    return static_cast<int>(std::ceil(kObstacleReach_m / voxel_size_m));
  }

  void add(std::size_t cell, const GroundNode& node) {
    const int key = static_cast<int>(std::lround(static_cast<double>(node.height_m) / slab_m_));
    Slab& slab = slabs_[key];
    if (slab.is_floor.empty()) {
      slab.is_floor.assign(extent_.numCells(), 0);
      slab.height_m.assign(extent_.numCells(), 0.0F);
      slab.is_ramp.assign(extent_.numCells(), 0);
    }
    if (slab.is_floor[cell] != 0) return;  // the lower one counts
    slab.is_floor[cell] = 1;
    slab.height_m[cell] = node.height_m;
    slab.is_ramp[cell] = node.is_ramp ? 1 : 0;
  }

  double voxel_size_m_;
  GridExtent extent_;
  double slab_m_;
  std::map<int, Slab> slabs_;
};

/// Reads the cells of one column of a ground plan.
class ColumnReader {
 public:
  ColumnReader(const VoxelMap& voxels, const PlacesConfig& config, const TileIndex& tile)
      : voxels_(voxels, tile), config_(config), tile_(tile) {}

  /// Something solid in the way of a body that stands at a height, or, near to floor and with its
  /// upper half observed free, more floor.
  void addBeside(int offset, const NearestFloor::Candidate& floor,
                 std::vector<SpaceCell>& cells) const {
    const double floor_m = static_cast<double>(floor.height_m);
    const double top_m = floor_m + config_.body_height_m;
    // a ramp stands for steps, the next of which is higher than it is beside it
    const bool is_stair = floor.is_ramp && floor.distance_m <= config_.max_floor_gap_m;
    const double step_m = (is_stair ? 2.0 : 1.0) * config_.max_step_m;
    const float solid_m = findSolid(voxels_, offset, floor_m + step_m, top_m);
    SpaceCell cell;
    cell.offset = static_cast<std::uint8_t>(offset);
    cell.level_m = floor.height_m;
    if (isSolid(solid_m)) {
      cell.offset_m = clampOffset(solid_m, voxels_.voxel_size_m);
      cells.push_back(cell);
    } else if (floor.distance_m <= config_.max_floor_gap_m &&
               isFreeBetween(voxels_, offset, floor_m + config_.body_height_m / 2.0, top_m)) {
      cell.is_free = true;
      cells.push_back(cell);
    }
  }

  /// Adds what lies beside floors to the floor of the column itself, where it is at least a body
  /// higher or lower than what is there already.
  void addColumn(int offset, const NearestFloor& floors, std::vector<float>& levels_m,
                 std::vector<SpaceCell>& cells) {
    floors.find(computeColumn(tile_, offset), candidates_);
    for (const auto& candidate : candidates_) {
      const auto is_near = [&](float level_m) {
        return std::abs(level_m - candidate.height_m) < static_cast<float>(config_.body_height_m);
      };
      if (std::any_of(levels_m.begin(), levels_m.end(), is_near)) continue;
      levels_m.push_back(candidate.height_m);
      addBeside(offset, candidate, cells);
    }
  }

 private:
  TileVoxels voxels_;
  const PlacesConfig& config_;
  TileIndex tile_;
  std::vector<NearestFloor::Candidate> candidates_;
};

std::vector<SpaceCell> readPlanTile(const TileIndex& index, const FloorMap& floors,
                                    const NearestFloor& nearest, ColumnReader& reader) {
  std::vector<SpaceCell> cells;
  std::array<std::vector<float>, kTileColumns> levels_m;
  floors.forEachFloor(index, [&](const GroundNode& node) {
    SpaceCell cell;
    cell.offset = static_cast<std::uint8_t>(node.offset);
    cell.is_free = true;
    cell.is_axis = node.is_axis;
    cell.level_m = node.height_m;
    cells.push_back(cell);
    levels_m[static_cast<std::size_t>(node.offset)].push_back(node.height_m);
  });
  floors.forEachDrop(index, [&](const GroundNode& node) {
    SpaceCell cell;
    cell.offset = static_cast<std::uint8_t>(node.offset);
    cell.level_m = node.height_m;
    cells.push_back(cell);
    levels_m[static_cast<std::size_t>(node.offset)].push_back(node.height_m);
  });
  for (int i = 0; i < kTileColumns; ++i) {
    reader.addColumn(i, nearest, levels_m[static_cast<std::size_t>(i)], cells);
  }
  std::sort(cells.begin(), cells.end(), [](const SpaceCell& a, const SpaceCell& b) {
    return a.offset == b.offset ? a.level_m < b.level_m : a.offset < b.offset;
  });
  return cells;
}

std::vector<SpaceCell> readVolumeTile(const VoxelMap& voxels, const WayMap& way,
                                      const TileIndex& index) {
  std::vector<SpaceCell> cells;
  const double voxel_size_m = voxels.voxelSize();
  const auto found = voxels.columns().find(index);
  if (found != voxels.columns().end()) {
    for (const auto& [block_z, block] : found->second) {
      for (int i = 0; i < mapping::kBlockVoxels; ++i) {
        const float distance_m = (*block)[static_cast<std::size_t>(i)];
        if (isNotObserved(distance_m)) continue;
        SpaceCell cell;
        cell.offset = static_cast<std::uint8_t>(i % kTileColumns);
        cell.is_free = isFree(distance_m);
        if (!cell.is_free) cell.offset_m = clampOffset(distance_m, voxel_size_m);
        const int z = block_z * mapping::kBlockSide + i / kTileColumns;
        cell.level_m = static_cast<float>((z + 0.5) * voxel_size_m);
        cells.push_back(cell);
      }
    }
  }
  for (const WayCell& walked : way.cellsAt(index)) {
    const auto level_m = static_cast<float>(walked.level_m);
    const auto same = std::find_if(cells.begin(), cells.end(), [&](const SpaceCell& cell) {
      return cell.offset == walked.offset &&
             std::abs(cell.level_m - level_m) < 0.5F * static_cast<float>(voxel_size_m);
    });
    SpaceCell cell;
    cell.offset = static_cast<std::uint8_t>(walked.offset);
    cell.is_free = true;
    cell.is_axis = walked.is_axis;
    cell.level_m = level_m;
    if (same == cells.end()) {
      cells.push_back(cell);
    } else if (walked.is_axis) {
      *same = cell;
    }
  }
  std::sort(cells.begin(), cells.end(), [](const SpaceCell& a, const SpaceCell& b) {
    return a.offset == b.offset ? a.level_m < b.level_m : a.offset < b.offset;
  });
  return cells;
}

}  // namespace

TileSet SpaceMap::updateCells(const VoxelMap& voxels, const FloorMap& floors, const TileSet& seen,
                              const TileSet& with_floor) {
  voxel_size_m_ = voxels.voxelSize();
  const int margin = static_cast<int>(std::ceil(kObstacleReach_m / voxel_size_m_));
  TileSet dirty = widen(with_floor, (margin + kTileSide - 1) / kTileSide);
  dirty.insert(seen.begin(), seen.end());
  TileSet result;
  for (const TileBox& box : coverByBoxes(dirty)) {
    const NearestFloor nearest(floors, config_, box, voxel_size_m_);
    for (const TileIndex& index : box.tiles) {
      ColumnReader reader(voxels, config_, index);
      if (replace(index, readPlanTile(index, floors, nearest, reader))) result.insert(index);
    }
  }
  return result;
}

TileSet SpaceMap::updateCells(const VoxelMap& voxels, const WayMap& way, const TileSet& changed) {
  voxel_size_m_ = voxels.voxelSize();
  TileSet result;
  for (const TileIndex& index : changed) {
    if (replace(index, readVolumeTile(voxels, way, index))) result.insert(index);
  }
  return result;
}

}  // namespace tsg::places
