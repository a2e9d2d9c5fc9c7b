// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/places/free_space.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tsg::places {
namespace {

/// An obstacle voxel's centre lies at most this far inside the surface.
float computeMinOffset(double voxel_size_m) {
  return static_cast<float>(-0.5 * std::sqrt(3.0) * voxel_size_m);
}

/// Obstacle cells and their signed distances.
struct Obstacles {
  std::vector<char> is_obstacle;
  std::vector<float> offset_m;

  explicit Obstacles(std::size_t cells) : is_obstacle(cells, 0), offset_m(cells, 0.0F) {}

  void set(std::size_t cell, float distance_m, double voxel_size_m) {
    is_obstacle[cell] = 1;
    offset_m[cell] = std::clamp(distance_m, computeMinOffset(voxel_size_m), 0.0F);
  }
};

GridExtent widen(const GridExtent& extent, int cells) {
  const GridIndex margin(cells, cells, 0);
  return {extent.min - margin, extent.size + 2 * margin};
}

/// The nearest walkable column of each cell.
struct Ground {
  std::vector<float> height_m;  ///< its ground; NaN if there is none within reach
  std::vector<double> distance_m;
};

Ground spreadGround(const Floor& floor, const GridExtent& extent, double voxel_size_m,
                    double max_distance_m) {
  std::vector<float> known_m(extent.numCells(), kNotObserved);
  std::vector<char> is_source(extent.numCells(), 0);
  for (std::size_t i = 0; i < floor.height_m.size(); ++i) {
    if (isUnknown(floor.height_m[i])) continue;
    const std::size_t cell = extent.toLinear(floor.extent.toIndex(i));
    is_source[cell] = 1;
    known_m[cell] = floor.height_m[i];
  }
  const NearestField nearest =
      computeNearestField(extent, is_source, max_distance_m / voxel_size_m);
  Ground ground{std::vector<float>(extent.numCells(), kNotObserved),
                std::vector<double>(extent.numCells(), 0.0)};
  for (std::size_t cell = 0; cell < extent.numCells(); ++cell) {
    if (nearest.source[cell] == NearestField::kNone) continue;
    ground.height_m[cell] = known_m[static_cast<std::size_t>(nearest.source[cell])];
    ground.distance_m[cell] =
        std::sqrt(static_cast<double>(nearest.squared_cells[cell])) * voxel_size_m;
  }
  return ground;
}

/// Distance of the solid voxel nearest to its surface between two heights; NaN if there is none.
float findSolid(const VoxelMap::Column& column, double voxel_size_m, double min_m, double max_m) {
  float found = kNotObserved;
  for (std::size_t i = 0; i < column.distances_m.size(); ++i) {
    const double z_m = (column.min_z + static_cast<double>(i) + 0.5) * voxel_size_m;
    const float distance_m = column.distances_m[i];
    if (z_m < min_m || z_m > max_m || !isSolid(distance_m)) continue;
    if (isUnknown(found) || distance_m > found) found = distance_m;
  }
  return found;
}

/// True if every voxel whose centre lies between two heights was observed free.
bool isFreeBetween(const VoxelMap::Column& column, double voxel_size_m, double min_m,
                   double max_m) {
  const int first = static_cast<int>(std::ceil(min_m / voxel_size_m - 0.5));
  const int last = static_cast<int>(std::floor(max_m / voxel_size_m - 0.5));
  const int size = static_cast<int>(column.distances_m.size());
  if (first < column.min_z || last >= column.min_z + size) return false;
  for (int z = first; z <= last; ++z) {
    if (!isFree(column.distances_m[static_cast<std::size_t>(z - column.min_z)])) return false;
  }
  return true;
}

/// Cells of a block column that are neither free nor out of reach of the floor.
std::vector<std::pair<std::size_t, std::size_t>> findOpenCells(const VoxelMap::ColumnIndex& index,
                                                               const FreeSpace& space,
                                                               const Ground& ground) {
  std::vector<std::pair<std::size_t, std::size_t>> cells;  // place in the block column, cell
  for (int i = 0; i < 64; ++i) {
    const GridIndex at(index.first * 8 + i % 8, index.second * 8 + i / 8, space.extent.min.z());
    if (!space.extent.contains(at)) continue;
    const std::size_t cell = space.extent.toLinear(at);
    if (isUnknown(ground.height_m[cell]) || space.is_free[cell] != 0) continue;
    cells.emplace_back(static_cast<std::size_t>(i), cell);
  }
  return cells;
}

/// Marks the columns with something solid where a body would be as obstacles, and those whose
/// floor was not seen but is next to floor that was as free.
void markColumns(const VoxelMap& voxels, const Ground& ground, const PlacesConfig& config,
                 FreeSpace& space, Obstacles& obstacles) {
  for (const auto& [index, blocks] : voxels.columns()) {
    const auto cells = findOpenCells(index, space, ground);
    if (cells.empty()) continue;
    const auto columns = voxels.readColumns(index);
    for (const auto& [i, cell] : cells) {
      const double floor_m = static_cast<double>(ground.height_m[cell]);
      const double top_m = floor_m + config.body_height_m;
      const float distance_m =
          findSolid(columns[i], space.voxel_size_m, floor_m + config.max_step_m, top_m);
      if (!isUnknown(distance_m)) {
        obstacles.set(cell, distance_m, space.voxel_size_m);
      } else if (ground.distance_m[cell] <= config.max_floor_gap_m) {
        const double middle_m = floor_m + config.body_height_m / 2.0;
        space.is_free[cell] = isFreeBetween(columns[i], space.voxel_size_m, middle_m, top_m);
      }
    }
  }
}

/// World z of the voxel centre in the middle of a body that stands on the ground. Whole voxels, so
/// that a place does not creep when the ground is refined.
std::vector<float> computeBodyCenters(const std::vector<float>& ground_m, double body_height_m,
                                      double voxel_size_m) {
  std::vector<float> centers_m(ground_m.size(), kNotObserved);
  for (std::size_t cell = 0; cell < ground_m.size(); ++cell) {
    const double middle_m = static_cast<double>(ground_m[cell]) + body_height_m / 2.0;
    centers_m[cell] =
        static_cast<float>((std::floor(middle_m / voxel_size_m) + 0.5) * voxel_size_m);
  }
  return centers_m;
}

}  // namespace

Eigen::Vector3d FreeSpace::computePosition(std::size_t cell) const {
  Eigen::Vector3d position_m = (extent.toIndex(cell).cast<double>().array() + 0.5) * voxel_size_m;
  if (!height_m.empty()) position_m.z() = static_cast<double>(height_m[cell]);
  return position_m;
}

void computeClearance(const std::vector<char>& is_obstacle, const std::vector<float>& offset_m,
                      double max_distance_m, FreeSpace& space) {
  const NearestField nearest =
      computeNearestField(space.extent, is_obstacle, max_distance_m / space.voxel_size_m);
  space.parent = nearest.source;
  space.clearance_m.assign(space.extent.numCells(), 0.0F);
  for (std::size_t cell = 0; cell < space.clearance_m.size(); ++cell) {
    if (space.is_free[cell] == 0) continue;
    double clearance_m = max_distance_m;
    if (nearest.source[cell] != NearestField::kNone) {
      clearance_m =
          std::sqrt(static_cast<double>(nearest.squared_cells[cell])) * space.voxel_size_m +
          static_cast<double>(offset_m[static_cast<std::size_t>(nearest.source[cell])]);
    }
    space.clearance_m[cell] = static_cast<float>(std::clamp(clearance_m, 0.0, max_distance_m));
  }
}

FreeSpace makeWalkableSpace(const VoxelMap& voxels, const Floor& floor,
                            const PlacesConfig& config) {
  FreeSpace space;
  space.voxel_size_m = voxels.voxelSize();
  const double reach = config.max_distance_m / space.voxel_size_m;
  space.extent = widen(floor.extent, static_cast<int>(std::ceil(reach)));
  requireBounded(space.extent, space.voxel_size_m);
  space.is_free.assign(space.extent.numCells(), 0);
  for (std::size_t i = 0; i < floor.height_m.size(); ++i) {
    const std::size_t cell = space.extent.toLinear(floor.extent.toIndex(i));
    space.is_free[cell] = isUnknown(floor.height_m[i]) ? 0 : 1;
  }
  const Ground ground =
      spreadGround(floor, space.extent, space.voxel_size_m, config.max_distance_m);
  Obstacles obstacles(space.extent.numCells());
  markColumns(voxels, ground, config, space, obstacles);
  computeClearance(obstacles.is_obstacle, obstacles.offset_m, config.max_distance_m, space);
  space.height_m = computeBodyCenters(ground.height_m, config.body_height_m, space.voxel_size_m);
  return space;
}

FreeSpace makeVolumeSpace(const VoxelMap& voxels, const std::vector<VoxelMap::ColumnIndex>& columns,
                          const PlacesConfig& config) {
  FreeSpace space;
  space.voxel_size_m = voxels.voxelSize();
  GridIndex min;
  GridIndex max;
  if (!voxels.computeBounds(columns, min, max)) return space;
  space.extent = {min, max - min + GridIndex::Ones()};
  requireBounded(space.extent, space.voxel_size_m);
  space.is_free.assign(space.extent.numCells(), 0);
  Obstacles obstacles(space.extent.numCells());
  for (const auto& index : columns) {
    for (const auto& [block_z, block] : voxels.columns().at(index)) {
      const GridIndex first = GridIndex(index.first, index.second, block_z) * mapping::kBlockSide;
      for (int i = 0; i < mapping::kBlockVoxels; ++i) {
        const std::size_t cell = space.extent.toLinear(first + GridIndex(i % 8, i / 8 % 8, i / 64));
        const float distance_m = (*block)[static_cast<std::size_t>(i)];
        space.is_free[cell] = isFree(distance_m) ? 1 : 0;
        if (isSolid(distance_m)) obstacles.set(cell, distance_m, space.voxel_size_m);
      }
    }
  }
  computeClearance(obstacles.is_obstacle, obstacles.offset_m, config.max_distance_m, space);
  return space;
}

}  // namespace tsg::places
