// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "task_scene_graph/core/files.h"
#include "task_scene_graph/places/ground_plan.h"

namespace tsg::planning {

/// One storey as a grid, in the values of nav_msgs/OccupancyGrid.
struct StoreyGrid {
  static constexpr std::int8_t kUnknown = -1;
  static constexpr std::int8_t kFree = 0;
  static constexpr std::int8_t kOccupied = 100;

  double floor_m = 0.0;                 ///< world z of most of its floor
  double cell_size_m = 0.0;             ///< side of a cell
  places::GroundPlan::Index min{0, 0};  ///< the cell with the smallest x and y
  int width = 0;                        ///< cells along x
  int height = 0;                       ///< cells along y
  std::vector<std::int8_t> cells;       ///< width * height, x fastest

  bool isEmpty() const { return cells.empty(); }
  bool contains(const places::GroundPlan::Index& cell) const {
    return cell.first >= min.first && cell.first < min.first + width && cell.second >= min.second &&
           cell.second < min.second + height;
  }
  std::int8_t at(const places::GroundPlan::Index& cell) const {
    return cells[static_cast<std::size_t>((cell.first - min.first) +
                                          width * (cell.second - min.second))];
  }
};

/// A rectangle of a storey's grid that has changed.
struct StoreyChange {
  std::size_t storey = 0;
  bool is_whole = false;  ///< the grid has other bounds than before, or another floor
  places::GroundPlan::Index min{0, 0};
  int width = 0;
  int height = 0;
};

/// Follows a ground plan and draws each storey as a grid. Storeys are heights that much floor lies
/// at, 1.8 m apart or more; whatever else is floor (stairs, a podium) belongs to the storey nearest
/// in height. A storey keeps its number, which counts from 0 in the order of being found.
/// Grids grow by 6.4 m and more at a time. What lies apart from most of the floor by more than 20 m
/// is left out where the grid would have more than 16 million cells (a pose gone astray).
class StoreyMap {
 public:
  static constexpr double kMinHeight_m = 1.8;
  static constexpr double kMinArea_m2 = 4.0;
  static constexpr double kMaxCells = 16e6;

  /// Draws what differs from the plan of the call before. O(tiles), and O(changed tiles * 64); all
  /// is drawn anew where storeys have been found or have moved.
  std::vector<StoreyChange> update(const places::GroundPlan& plan);

  const std::vector<StoreyGrid>& storeys() const { return storeys_; }

 private:
  using Index = places::GroundPlan::Index;
  using Tiles = std::vector<places::GroundPlan::TilePtr>;

  std::vector<Index> findChangedTiles(const places::GroundPlan& plan) const;
  void countFloor(const Tiles& tiles, int sign);
  /// True if a storey was found or has moved.
  bool updateHeights();
  /// The storey of a floor height; storeys().size() if there is none yet.
  std::size_t findStorey(float floor_m) const;
  bool isOfStorey(const Tiles& tiles, std::size_t storey) const;
  StoreyChange findBounds(std::size_t storey) const;
  StoreyChange drawAll(const StoreyChange& bounds);
  StoreyChange drawSome(std::size_t storey, const std::vector<Index>& tiles);
  void drawTile(const Index& tile, std::size_t storey);

  places::GroundPlan plan_;
  std::map<int, int> floor_cells_;  ///< free cells by height, in steps of 0.1 m
  std::vector<StoreyGrid> storeys_;
};

/// Writes `floor_<n>.pgm` and `floor_<n>.yaml` of each storey with cells, as map_saver does and
/// map_server reads. @throws std::runtime_error naming the path.
std::vector<WrittenFile> writeStoreyFiles(const std::filesystem::path& folder,
                                          const std::vector<StoreyGrid>& storeys);

}  // namespace tsg::planning
