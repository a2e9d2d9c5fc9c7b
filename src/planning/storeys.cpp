// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/planning/storeys.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>
#include <tuple>
#include <utility>

namespace tsg::planning {
namespace {

using places::divideFloor;
using places::GroundPlan;
using places::PlanCell;
using Index = GroundPlan::Index;

constexpr int kSide = GroundPlan::kTileSide;
/// Of the heights that are counted.
constexpr double kBin_m = 0.1;
/// A storey's floor is counted within so many bins.
constexpr int kWindow = 3;
/// Grids begin and end at multiples of so many tiles.
constexpr int kBlockTiles = 8;

std::int8_t toOccupancy(PlanCell::State state) {
  switch (state) {
    case PlanCell::State::kFree:
      return StoreyGrid::kFree;
    case PlanCell::State::kObstacle:
      return StoreyGrid::kOccupied;
    case PlanCell::State::kUnknown:
      break;
  }
  return StoreyGrid::kUnknown;
}

/// The longest run of sorted numbers, counted as often as they stand there, without a gap of more
/// than `max_gap`: first and last.
std::pair<int, int> findLongestRun(const std::vector<int>& sorted, int max_gap) {
  std::pair<std::size_t, std::size_t> best{0, 0};
  std::size_t first = 0;
  for (std::size_t i = 1; i <= sorted.size(); ++i) {
    if (i < sorted.size() && sorted[i] - sorted[i - 1] <= max_gap) continue;
    if (i - first > best.second - best.first) best = {first, i};
    first = i;
  }
  return {sorted[best.first], sorted[best.second - 1]};
}

struct TileBounds {
  Index min{0, 0};
  Index max{0, 0};  ///< the last one

  bool contains(const Index& tile) const {
    return tile.first >= min.first && tile.first <= max.first && tile.second >= min.second &&
           tile.second <= max.second;
  }
  double numCells() const {
    return static_cast<double>(max.first - min.first + 1) * (max.second - min.second + 1) *
           (kSide * kSide);
  }
};

TileBounds computeBounds(const std::vector<Index>& tiles, int max_gap) {
  std::vector<int> x;
  for (const Index& tile : tiles) x.push_back(tile.first);
  std::sort(x.begin(), x.end());
  TileBounds bounds;
  std::tie(bounds.min.first, bounds.max.first) = findLongestRun(x, max_gap);
  std::vector<int> y;
  for (const Index& tile : tiles) {
    if (tile.first >= bounds.min.first && tile.first <= bounds.max.first) y.push_back(tile.second);
  }
  std::sort(y.begin(), y.end());
  std::tie(bounds.min.second, bounds.max.second) = findLongestRun(y, max_gap);
  return bounds;
}

struct Level {
  double height_m = 0.0;
  double area_m2 = 0.0;
};

/// Mean height and area of the floor around each height at which there is some; largest first.
std::vector<Level> findLevels(const std::map<int, int>& floor_cells, double cell_size_m) {
  std::vector<Level> levels;
  for (const auto& item : floor_cells) {
    int cells = 0;
    double sum = 0.0;
    auto it = floor_cells.lower_bound(item.first - kWindow);
    for (; it != floor_cells.end() && it->first <= item.first + kWindow; ++it) {
      cells += it->second;
      sum += (it->first + 0.5) * it->second;
    }
    levels.push_back({kBin_m * sum / cells, cells * cell_size_m * cell_size_m});
  }
  std::stable_sort(levels.begin(), levels.end(),
                   [](const Level& a, const Level& b) { return a.area_m2 > b.area_m2; });
  return levels;
}

void writePgm(std::ostream& out, const StoreyGrid& grid) {
  out << "P5\n" << grid.width << ' ' << grid.height << "\n255\n";
  // The image's first row is the one with the greatest y.
  for (int y = grid.height - 1; y >= 0; --y) {
    for (int x = 0; x < grid.width; ++x) {
      const std::int8_t value = grid.cells[static_cast<std::size_t>(x + grid.width * y)];
      const int grey =
          value == StoreyGrid::kFree ? 254 : (value == StoreyGrid::kOccupied ? 0 : 205);
      out.put(static_cast<char>(grey));
    }
  }
}

void writeYaml(std::ostream& out, const StoreyGrid& grid, const std::string& image) {
  out.precision(9);
  out << "# Floor at z = " << grid.floor_m << " m.\nimage: " << image
      << "\nresolution: " << grid.cell_size_m << "\norigin: [" << grid.min.first * grid.cell_size_m
      << ", " << grid.min.second * grid.cell_size_m
      << ", 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
}

}  // namespace

std::vector<Index> StoreyMap::findChangedTiles(const GroundPlan& plan) const {
  std::vector<Index> changed;
  auto before = plan_.tiles().begin();
  auto now = plan.tiles().begin();
  while (before != plan_.tiles().end() || now != plan.tiles().end()) {
    if (now == plan.tiles().end() ||
        (before != plan_.tiles().end() && before->first < now->first)) {
      changed.push_back((before++)->first);
    } else if (before == plan_.tiles().end() || now->first < before->first) {
      changed.push_back((now++)->first);
    } else {
      if (before->second != now->second) changed.push_back(now->first);
      ++before;
      ++now;
    }
  }
  return changed;
}

void StoreyMap::countFloor(const Tiles& tiles, int sign) {
  for (const auto& tile : tiles) {
    for (const PlanCell& cell : *tile) {
      if (!cell.isFree() || !std::isfinite(cell.floor_m)) continue;
      const int bin = static_cast<int>(std::floor(static_cast<double>(cell.floor_m) / kBin_m));
      const auto at = floor_cells_.emplace(bin, 0).first;
      at->second += sign;
      if (at->second == 0) floor_cells_.erase(at);
    }
  }
}

bool StoreyMap::updateHeights() {
  bool has_changed = false;
  std::vector<double> taken_m;
  for (const Level& level : findLevels(floor_cells_, plan_.cellSize())) {
    if (level.area_m2 < kMinArea_m2) break;
    const auto isNear = [&](double height_m) {
      return std::abs(height_m - level.height_m) < kMinHeight_m;
    };
    if (std::any_of(taken_m.begin(), taken_m.end(), isNear)) continue;
    taken_m.push_back(level.height_m);
    const auto known = std::find_if(storeys_.begin(), storeys_.end(), [&](const StoreyGrid& grid) {
      return std::abs(grid.floor_m - level.height_m) < kMinHeight_m / 2.0;
    });
    // Where the mean moves a little, no cell gets into another storey.
    constexpr double kMoved_m = 0.3;
    if (known != storeys_.end() && std::abs(known->floor_m - level.height_m) < kMoved_m) continue;
    has_changed = true;
    const auto storey = static_cast<std::size_t>(known - storeys_.begin());
    storeys_.resize(std::max(storeys_.size(), storey + 1));
    StoreyGrid& grid = storeys_[storey];
    grid.floor_m = level.height_m;
    grid.cell_size_m = plan_.cellSize();
  }
  return has_changed;
}

std::size_t StoreyMap::findStorey(float floor_m) const {
  std::size_t best = storeys_.size();
  double best_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < storeys_.size(); ++i) {
    const double away_m = std::abs(static_cast<double>(floor_m) - storeys_[i].floor_m);
    if (away_m >= best_m) continue;
    best = i;
    best_m = away_m;
  }
  return best;
}

bool StoreyMap::isOfStorey(const Tiles& tiles, std::size_t storey) const {
  for (const auto& tile : tiles) {
    for (const PlanCell& cell : *tile) {
      if (cell.state == PlanCell::State::kUnknown || !std::isfinite(cell.floor_m)) continue;
      if (findStorey(cell.floor_m) == storey) return true;
    }
  }
  return false;
}

/// Bounds of all tiles of a storey; no cells if there is none.
StoreyChange StoreyMap::findBounds(std::size_t storey) const {
  std::vector<Index> own;
  for (const auto& [index, tiles] : plan_.tiles()) {
    if (isOfStorey(tiles, storey)) own.push_back(index);
  }
  StoreyChange bounds{storey, true, {0, 0}, 0, 0};
  if (own.empty()) return bounds;
  TileBounds tiles = computeBounds(own, std::numeric_limits<int>::max());
  if (tiles.numCells() > kMaxCells) {
    constexpr double kMaxGap_m = 20.0;
    tiles = computeBounds(own, static_cast<int>(kMaxGap_m / (kSide * plan_.cellSize())));
  }
  const auto roundDown = [](int tile) { return divideFloor(tile, kBlockTiles) * kBlockTiles; };
  bounds.min = {roundDown(tiles.min.first) * kSide, roundDown(tiles.min.second) * kSide};
  bounds.width = (roundDown(tiles.max.first) + kBlockTiles) * kSide - bounds.min.first;
  bounds.height = (roundDown(tiles.max.second) + kBlockTiles) * kSide - bounds.min.second;
  return bounds;
}

void StoreyMap::drawTile(const Index& tile, std::size_t storey) {
  StoreyGrid& grid = storeys_[storey];
  const Tiles& tiles = plan_.tilesAt(tile);
  for (int i = 0; i < kSide * kSide; ++i) {
    const PlanCell* best = nullptr;
    for (const auto& floor : tiles) {
      const PlanCell& cell = (*floor)[static_cast<std::size_t>(i)];
      if (!std::isfinite(cell.floor_m) || findStorey(cell.floor_m) != storey) continue;
      const auto away_m = [&](const PlanCell& of) {
        return std::abs(static_cast<double>(of.floor_m) - grid.floor_m);
      };
      if (best == nullptr || away_m(cell) < away_m(*best)) best = &cell;
    }
    const int x = tile.first * kSide + i % kSide - grid.min.first;
    const int y = tile.second * kSide + i / kSide - grid.min.second;
    grid.cells[static_cast<std::size_t>(x + grid.width * y)] =
        best == nullptr ? StoreyGrid::kUnknown : toOccupancy(best->state);
  }
}

StoreyChange StoreyMap::drawAll(const StoreyChange& bounds) {
  StoreyGrid& grid = storeys_[bounds.storey];
  grid.min = bounds.min;
  grid.width = bounds.width;
  grid.height = bounds.height;
  grid.cells.assign(
      static_cast<std::size_t>(bounds.width) * static_cast<std::size_t>(bounds.height),
      StoreyGrid::kUnknown);
  for (const auto& [index, tiles] : plan_.tiles()) {
    if (grid.contains({index.first * kSide, index.second * kSide})) drawTile(index, bounds.storey);
  }
  return bounds;
}

/// Draws those that lie in the grid. @returns the rectangle that holds them; no cells if none does
StoreyChange StoreyMap::drawSome(std::size_t storey, const std::vector<Index>& tiles) {
  StoreyChange change{storey, false, {0, 0}, 0, 0};
  Index end{0, 0};
  for (const Index& tile : tiles) {
    const Index low{tile.first * kSide, tile.second * kSide};
    if (!storeys_[storey].contains(low)) continue;
    drawTile(tile, storey);
    const bool is_first = change.width == 0;
    change.min = is_first ? low
                          : Index{std::min(change.min.first, low.first),
                                  std::min(change.min.second, low.second)};
    end = {std::max(is_first ? low.first + kSide : end.first, low.first + kSide),
           std::max(is_first ? low.second + kSide : end.second, low.second + kSide)};
    change.width = end.first - change.min.first;
    change.height = end.second - change.min.second;
  }
  return change;
}

std::vector<StoreyChange> StoreyMap::update(const GroundPlan& plan) {
  const std::vector<Index> changed = findChangedTiles(plan);
  for (const Index& tile : changed) {
    countFloor(plan_.tilesAt(tile), -1);
    countFloor(plan.tilesAt(tile), 1);
  }
  const GroundPlan before = std::exchange(plan_, plan);
  if (changed.empty()) return {};
  const bool has_moved = updateHeights();
  std::vector<StoreyChange> changes;
  for (std::size_t storey = 0; storey < storeys_.size(); ++storey) {
    const StoreyGrid& grid = storeys_[storey];
    std::vector<Index> own;
    bool is_outside = has_moved || grid.isEmpty();
    for (const Index& tile : changed) {
      const bool is_now = isOfStorey(plan_.tilesAt(tile), storey);
      if (!is_now && !isOfStorey(before.tilesAt(tile), storey)) continue;
      own.push_back(tile);
      is_outside = is_outside || !grid.contains({tile.first * kSide, tile.second * kSide});
    }
    StoreyChange bounds = is_outside ? findBounds(storey) : StoreyChange{};
    const bool is_larger = is_outside && (bounds.min != grid.min || bounds.width != grid.width ||
                                          bounds.height != grid.height);
    StoreyChange change = has_moved || is_larger ? drawAll(bounds) : drawSome(storey, own);
    if (change.is_whole || change.width > 0) changes.push_back(change);
  }
  return changes;
}

std::vector<WrittenFile> writeStoreyFiles(const std::filesystem::path& folder,
                                          const std::vector<StoreyGrid>& storeys) {
  std::vector<WrittenFile> files;
  for (std::size_t i = 0; i < storeys.size(); ++i) {
    const StoreyGrid& grid = storeys[i];
    if (grid.isEmpty()) continue;
    const std::string name = "floor_" + std::to_string(i);
    writeFileAtomically(folder / (name + ".pgm"), [&](std::ostream& out) { writePgm(out, grid); });
    writeFileAtomically(folder / (name + ".yaml"),
                        [&](std::ostream& out) { writeYaml(out, grid, name + ".pgm"); });
    const std::string size =
        std::to_string(grid.width) + " x " + std::to_string(grid.height) + " cells";
    files.push_back({name + ".pgm", size});
    files.push_back({name + ".yaml", ""});
  }
  return files;
}

}  // namespace tsg::planning
