// SPDX-License-Identifier: BSD-3-Clause
#include "place_cells.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace tsg::places {
namespace {

bool isSame(const PlaceSeed& a, const PlaceSeed& b) {
  return a.cell == b.cell && a.level_m == b.level_m && a.clearance_m == b.clearance_m;
}

/// Better: more clearance, then the order of cells.
bool isBetter(const PlaceSeed& a, const PlaceSeed& b) {
  return a.clearance_m == b.clearance_m ? CellOrder{}(a.cell, b.cell)
                                        : a.clearance_m > b.clearance_m;
}

bool isBefore(const PlaceSeed& a, const PlaceSeed& b) { return CellOrder{}(a.cell, b.cell); }

/// The seed of largest clearance; among equals the one nearest to the middle of all.
PlaceSeed chooseOffer(const std::vector<PlaceSeed>& set) {
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  for (const PlaceSeed& seed : set) middle_m += seed.position_m;
  middle_m /= static_cast<double>(set.size());
  const auto isWorse = [&](const PlaceSeed& a, const PlaceSeed& b) {
    if (a.clearance_m != b.clearance_m) return a.clearance_m < b.clearance_m;
    const double a_m = (a.position_m - middle_m).norm();
    const double b_m = (b.position_m - middle_m).norm();
    return a_m == b_m ? isBefore(b, a) : a_m > b_m;
  };
  return *std::max_element(set.begin(), set.end(), isWorse);
}

/// Calls `visit(cell)` for the free cells that touch one, corners included.
template <typename Visit>
void forEachBeside(const SpaceMap& space, const PlaceSeed& at, Visit visit) {
  const bool is_plan = space.isPlan();
  const double tolerance_m = is_plan ? space.maxStep() : 0.5 * space.voxelSize();
  for (int i = is_plan ? 9 : 0; i < (is_plan ? 18 : 27); ++i) {
    const Column column{at.cell.x() + i % 3 - 1, at.cell.y() + i / 3 % 3 - 1};
    const double level_m = static_cast<double>(at.level_m) + (i / 9 - 1) * space.voxelSize();
    if (const SpaceCell* cell = space.findFree(column, level_m, tolerance_m)) visit(cell);
  }
}

int floorDivide(double value, double divisor) {
  return static_cast<int>(std::floor(value / divisor));
}

}  // namespace

std::ptrdiff_t PlaceCells::Cell::begin(int part) const {
  return std::accumulate(counts_.begin(), counts_.begin() + part, std::ptrdiff_t{0});
}

bool PlaceCells::Cell::replace(int part, const std::vector<PlaceSeed>& places) {
  const auto first = places_.begin() + begin(part);
  const auto last = places_.begin() + begin(part + 1);
  if (std::equal(first, last, places.begin(), places.end(), isSame)) return false;
  std::vector<PlaceSeed> all(places_.begin(), first);
  all.reserve(places_.size() + places.size() - static_cast<std::size_t>(last - first));
  all.insert(all.end(), places.begin(), places.end());
  all.insert(all.end(), last, places_.end());
  places_ = std::move(all);
  counts_[static_cast<std::size_t>(part)] = static_cast<std::uint16_t>(places.size());
  return true;
}

double PlaceCells::spacing() const {
  const double spacing_m = std::min(config_.fill_distance_m, config_.cell_size_m);
  return spacing_m > 0.0 ? spacing_m : config_.cell_size_m;
}

GridIndex PlaceCells::computeCoarse(const Eigen::Vector3d& p_m) const {
  GridIndex coarse(floorDivide(p_m.x(), config_.cell_size_m),
                   floorDivide(p_m.y(), config_.cell_size_m), 0);
  if (!isPlan()) coarse.z() = floorDivide(p_m.z(), config_.cell_size_m);
  return coarse;
}

const std::vector<PlaceSeed>& PlaceCells::placesAt(const GridIndex& coarse) const {
  static const std::vector<PlaceSeed> kNone;
  const auto found = cells_.find(coarse);
  return found == cells_.end() ? kNone : found->second.places();
}

/// Along one axis after the other.
CoarseSet PlaceCells::widen(const CoarseSet& cells, int rings) const {
  std::vector<GridIndex> wide(cells.begin(), cells.end());
  for (int axis = 0; axis < (isPlan() ? 2 : 3); ++axis) {
    std::vector<GridIndex> next;
    next.reserve(wide.size() * static_cast<std::size_t>(2 * rings + 1));
    for (const GridIndex& at : wide) {
      for (int step = -rings; step <= rings; ++step) {
        next.push_back(at);
        next.back()[axis] += step;
      }
    }
    std::sort(next.begin(), next.end(), CellOrder{});
    next.erase(std::unique(next.begin(), next.end()), next.end());
    wide = std::move(next);
  }
  return {wide.begin(), wide.end()};
}

CoarseSet PlaceCells::findCoarse(const SpaceMap& space, const TileSet& tiles) const {
  CoarseSet result;
  const double tile_m = kTileSide * space.voxelSize();
  const double inside_m = 0.5 * space.voxelSize();  // centres of the outermost columns
  for (const TileIndex& tile : tiles) {
    std::set<int> levels{0};
    if (!isPlan()) {
      levels.clear();
      if (const SpaceTile* cells = space.find(tile)) {
        for (const SpaceCell& cell : cells->cells) {
          levels.insert(floorDivide(static_cast<double>(cell.level_m), config_.cell_size_m));
        }
      }
    }
    const Eigen::Vector2d min_m = tile_m * Eigen::Vector2d(tile.first, tile.second);
    const int x1 = floorDivide(min_m.x() + tile_m - inside_m, config_.cell_size_m);
    const int y1 = floorDivide(min_m.y() + tile_m - inside_m, config_.cell_size_m);
    for (int x = floorDivide(min_m.x() + inside_m, config_.cell_size_m); x <= x1; ++x) {
      for (int y = floorDivide(min_m.y() + inside_m, config_.cell_size_m); y <= y1; ++y) {
        for (const int z : levels) result.insert({x, y, z});
      }
    }
  }
  return result;
}

CoarseSet PlaceCells::update(const SpaceMap& space, const TileSet& tiles) {
  const CoarseSet dirty = findCoarse(space, tiles);
  const CoarseSet around = widen(dirty, mergeRings());
  CoarseSet changed;
  for (const GridIndex& at : dirty) {
    auto offers = findOffers(space, at);
    if (!offers.empty() || cells_.count(at) > 0) cells_[at].offers = std::move(offers);
  }
  for (const GridIndex& at : around) {
    if (replace(at, Cell::kKept, findKept(space, at))) changed.insert(at);
  }
  for (int step = 0; step < kNumSteps; ++step) {
    CoarseSet to_fill = widen(changed, 1);
    to_fill.insert(around.begin(), around.end());
    for (const GridIndex& at : to_fill) {
      if ((at.x() & 1) + 2 * (at.y() & 1) != step % 4) continue;
      if (replace(at, 1 + step, fill(space, at, step))) changed.insert(at);
    }
  }
  for (const CoarseSet* touched : {&around, &std::as_const(changed)}) {
    for (const GridIndex& at : *touched) {
      const auto cell = cells_.find(at);
      if (cell != cells_.end() && cell->second.isEmpty()) cells_.erase(cell);
    }
  }
  return changed;
}

/// @returns whether the places of a part of a coarse cell are others than before.
bool PlaceCells::replace(const GridIndex& at, int part, const std::vector<PlaceSeed>& places) {
  const auto cell = cells_.find(at);
  if (cell != cells_.end()) return cell->second.replace(part, places);
  return !places.empty() && cells_[at].replace(part, places);
}

/// The free cells in a coarse cell.
std::vector<PlaceCells::Candidate> PlaceCells::collect(const SpaceMap& space,
                                                       const GridIndex& coarse) const {
  std::vector<Candidate> found;
  const double size_m = config_.cell_size_m;
  const double voxel_size_m = space.voxelSize();
  const auto toColumn = [&](int edge) { return floorDivide(edge * size_m, voxel_size_m); };
  TileIndex last;
  const SpaceTile* tile = nullptr;
  bool is_first = true;
  for (int y = toColumn(coarse.y()); y <= toColumn(coarse.y() + 1); ++y) {
    for (int x = toColumn(coarse.x()); x <= toColumn(coarse.x() + 1); ++x) {
      const Column column{x, y};
      if (is_first || computeTile(column) != last) {
        last = computeTile(column);
        tile = space.find(last);
        is_first = false;
      }
      if (tile == nullptr) continue;
      const auto offset = static_cast<std::size_t>(computeOffset(column));
      for (std::uint32_t i = tile->begin[offset]; i < tile->begin[offset + 1]; ++i) {
        const SpaceCell& cell = tile->cells[i];
        const Eigen::Vector3d p_m((x + 0.5) * voxel_size_m, (y + 0.5) * voxel_size_m,
                                  static_cast<double>(cell.level_m));
        if (cell.is_free && computeCoarse(p_m) == coarse) found.push_back({column, &cell, {}});
      }
    }
  }
  return found;
}

/// A place of a plan lies in the middle of a body that stands there: whole voxels, so that it does
/// not creep when the ground is refined.
PlaceSeed PlaceCells::makeSeed(const SpaceMap& space, const Column& column,
                               const SpaceCell& cell) const {
  const double voxel_size_m = space.voxelSize();
  const auto level_m = static_cast<double>(cell.level_m);
  const double middle_m = isPlan() ? level_m + config_.body_height_m / 2.0 : level_m;
  const int z = floorDivide(middle_m, voxel_size_m);
  PlaceSeed seed;
  seed.cell = {column.x, column.y, z};
  seed.level_m = cell.level_m;
  seed.clearance_m = cell.clearance_m;
  seed.position_m = (seed.cell.cast<double>().array() + 0.5) * voxel_size_m;
  return seed;
}

/// Connected sets of Voronoi cells, the best of each.
std::vector<PlaceSeed> PlaceCells::findOffers(const SpaceMap& space,
                                              const GridIndex& coarse) const {
  std::vector<PlaceSeed> cells;
  std::map<const SpaceCell*, std::size_t> index_of;
  for (const Candidate& candidate : collect(space, coarse)) {
    if (!candidate.cell->is_voronoi) continue;
    index_of[candidate.cell] = cells.size();
    cells.push_back(makeSeed(space, candidate.column, *candidate.cell));
  }
  std::vector<char> is_taken(cells.size(), 0);
  std::vector<PlaceSeed> offers;
  for (std::size_t first = 0; first < cells.size(); ++first) {
    if (is_taken[first] != 0) continue;
    std::vector<PlaceSeed> set{cells[first]};
    is_taken[first] = 1;
    for (std::size_t i = 0; i < set.size(); ++i) {
      const PlaceSeed at = set[i];  // a copy: the set grows meanwhile
      forEachBeside(space, at, [&](const SpaceCell* next) {
        const auto found = index_of.find(next);
        if (found == index_of.end() || is_taken[found->second] != 0) return;
        is_taken[found->second] = 1;
        set.push_back(cells[found->second]);
      });
    }
    offers.push_back(chooseOffer(set));
  }
  std::sort(offers.begin(), offers.end(), isBefore);
  return offers;
}

std::vector<PlaceSeed> PlaceCells::findKept(const SpaceMap& space, const GridIndex& coarse) const {
  const auto own = cells_.find(coarse);
  if (own == cells_.end()) return {};
  const int rings = mergeRings();
  const int rings_z = isPlan() ? 0 : rings;
  const auto isDropped = [&](const PlaceSeed& offer) {
    for (int z = -rings_z; z <= rings_z; ++z) {
      for (int y = -rings; y <= rings; ++y) {
        for (int x = -rings; x <= rings; ++x) {
          const auto found = cells_.find(coarse + GridIndex(x, y, z));
          if (found == cells_.end()) continue;
          for (const PlaceSeed& other : found->second.offers) {
            if ((other.position_m - offer.position_m).norm() >= config_.merge_distance_m) continue;
            if (!isBetter(other, offer)) continue;
            if (followLine(space, offer, other).is_free) return true;
          }
        }
      }
    }
    return false;
  };
  std::vector<PlaceSeed> kept;
  for (const PlaceSeed& offer : own->second.offers) {
    if (!isDropped(offer)) kept.push_back(offer);
  }
  return kept;
}

bool PlaceCells::reaches(const SpaceMap& space, const SpaceCell& cell, const PlaceSeed& seed,
                         const PlaceSeed& place) const {
  const FreeLine line = followLine(space, seed, place);
  return line.is_free && (!cell.is_voronoi || line.clearance_m >= config_.min_edge_clearance_m);
}

bool PlaceCells::isCovered(const SpaceMap& space, const Candidate& candidate,
                           const PlaceSeed& place, bool is_trace) const {
  const PlaceSeed& seed = candidate.seed;
  const bool is_way = is_trace && candidate.cell->is_axis;
  const double reach_m = is_way ? std::min(spacing(), config_.merge_distance_m) : spacing();
  if ((seed.position_m - place.position_m).norm() > reach_m) return false;
  return !is_trace || reaches(space, *candidate.cell, seed, place);
}

std::vector<PlaceSeed> PlaceCells::fill(const SpaceMap& space, const GridIndex& coarse,
                                        int step) const {
  const bool is_trace = step >= 4;
  if (!is_trace && (!isPlan() || config_.fill_distance_m == 0.0)) return {};
  std::vector<PlaceSeed> near;
  const int rings_z = isPlan() ? 0 : 1;
  for (int i = 9 * (1 - rings_z); i < 9 * (2 + rings_z); ++i) {
    const auto found = cells_.find(coarse + GridIndex(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
    if (found == cells_.end()) continue;
    found->second.forEachOf(1 + step, [&](const PlaceSeed& place) { near.push_back(place); });
  }
  std::vector<PlaceSeed> filled;
  for (const Candidate& candidate : findOpen(space, coarse, is_trace)) {
    const bool is_covered = std::any_of(near.begin(), near.end(), [&](const PlaceSeed& place) {
      return isCovered(space, candidate, place, is_trace);
    });
    if (is_covered) continue;
    filled.push_back(candidate.seed);
    near.push_back(candidate.seed);
  }
  std::sort(filled.begin(), filled.end(), isBefore);
  return filled;
}

/// Cells that may become places to fill a coarse cell, those nearest to its middle first.
std::vector<PlaceCells::Candidate> PlaceCells::findOpen(const SpaceMap& space,
                                                        const GridIndex& coarse,
                                                        bool is_trace) const {
  const Eigen::Vector2d middle_m =
      config_.cell_size_m * Eigen::Vector2d(coarse.x() + 0.5, coarse.y() + 0.5);
  std::vector<std::pair<double, Candidate>> open;
  for (Candidate& candidate : collect(space, coarse)) {
    const SpaceCell& cell = *candidate.cell;
    const bool is_wanted =
        is_trace ? isTrace(cell) : static_cast<double>(cell.clearance_m) >= config_.min_clearance_m;
    if (!is_wanted) continue;
    candidate.seed = makeSeed(space, candidate.column, cell);
    open.emplace_back((candidate.seed.position_m.head<2>() - middle_m).norm(), candidate);
  }
  std::sort(open.begin(), open.end(), [](const auto& a, const auto& b) {
    return a.first == b.first ? isBefore(a.second.seed, b.second.seed) : a.first < b.first;
  });
  std::vector<Candidate> candidates;
  for (auto& [offset_m, candidate] : open) candidates.push_back(candidate);
  return candidates;
}

int PlaceCells::mergeRings() const {
  return static_cast<int>(std::ceil(config_.merge_distance_m / config_.cell_size_m));
}

}  // namespace tsg::places
