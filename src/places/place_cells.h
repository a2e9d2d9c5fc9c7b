// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "space_map.h"
#include "task_scene_graph/places/places_config.h"

namespace tsg::places {

/// Orders cells, coarse ones as well, by z, y, x.
struct CellOrder {
  bool operator()(const GridIndex& a, const GridIndex& b) const {
    return std::tuple(a.z(), a.y(), a.x()) < std::tuple(b.z(), b.y(), b.x());
  }
};
using CellSet = std::set<GridIndex, CellOrder>;
using CoarseSet = CellSet;

/// A cell chosen as a place. Its voxel is its key: no two places share one.
struct PlaceSeed {
  GridIndex cell = GridIndex::Zero();  ///< voxel in which the place lies
  float level_m = 0.0F;                ///< of the SpaceCell
  float clearance_m = 0.0F;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
};

inline FreeLine followLine(const SpaceMap& space, const PlaceSeed& from, const PlaceSeed& to,
                           double min_clearance_m = 0.0) {
  return followLine(space, from.cell, static_cast<double>(from.level_m), to.cell,
                    static_cast<double>(to.level_m), min_clearance_m);
}

/// Chooses places among the cells of free space, coarse cell by coarse cell (squares, `volume`:
/// cubes, of `cell_size_m`). Each step is a function of the coarse cells around alone, so that a
/// change stays local and the result of updates is that of a computation from scratch:
///   1. every connected set of Voronoi cells in a coarse cell offers the cell of largest clearance;
///   2. an offer is dropped for a better one (larger clearance) nearer than `merge_distance_m` with
///      free space between;
///   3. of a plan: open cells (clearance >= min_clearance_m) farther than `fill_distance_m` from
///   all
///      places become places, nearest to the middle of the coarse cell first; coarse cells take
///      turns in four colours, so that no two neighbours choose at once;
///   4. in the same way cells of the diagram and of the axis of the body's way that reach no place
///      so near (reaches()).
class PlaceCells {
 public:
  explicit PlaceCells(const PlacesConfig& config) : config_(config) {}

  /// @param tiles  with a cell that changed in any way
  /// @returns the coarse cells whose places changed. O(changed tiles).
  CoarseSet update(const SpaceMap& space, const TileSet& tiles);

  /// Coarse cells that meet a tile.
  CoarseSet findCoarse(const SpaceMap& space, const TileSet& tiles) const;
  GridIndex computeCoarse(const Eigen::Vector3d& p_m) const;
  /// Adds all coarse cells at most `rings` away.
  CoarseSet widen(const CoarseSet& cells, int rings) const;
  /// How far apart places are at least, where the diagram does not say.
  double spacing() const;
  /// Whether the straight line from a cell of the diagram to a place is free with
  /// `min_edge_clearance_m`, from another cell of the body's way free at all.
  bool reaches(const SpaceMap& space, const SpaceCell& cell, const PlaceSeed& seed,
               const PlaceSeed& place) const;
  PlaceSeed makeSeed(const SpaceMap& space, const Column& column, const SpaceCell& cell) const;

  /// Places of a coarse cell, in a fixed order.
  const std::vector<PlaceSeed>& placesAt(const GridIndex& coarse) const;
  /// Calls `visit(seed)` for all places at most `radius_m` from a point, in coarse cells for which
  /// `is_wanted(coarse)` holds.
  template <typename IsWanted, typename Visit>
  void forEachNear(const Eigen::Vector3d& p_m, double radius_m, IsWanted is_wanted,
                   Visit visit) const {
    const GridIndex middle = computeCoarse(p_m);
    const auto rings = static_cast<int>(std::ceil(radius_m / config_.cell_size_m));
    const int rings_z = isPlan() ? 0 : rings;
    for (int z = -rings_z; z <= rings_z; ++z) {
      for (int y = -rings; y <= rings; ++y) {
        for (int x = -rings; x <= rings; ++x) {
          const GridIndex coarse = middle + GridIndex(x, y, z);
          if (!is_wanted(coarse)) continue;
          for (const PlaceSeed& seed : placesAt(coarse)) {
            if ((seed.position_m - p_m).squaredNorm() <= radius_m * radius_m) visit(seed);
          }
        }
      }
    }
  }

 private:
  static constexpr int kNumSteps = 8;  ///< four colours for open space, four for traces
  /// The places of a coarse cell, part by part: those kept of the offers, then those of each step.
  class Cell {
   public:
    static constexpr int kKept = 0;
    static constexpr int kNumParts = 1 + kNumSteps;

    std::vector<PlaceSeed> offers;

    const std::vector<PlaceSeed>& places() const { return places_; }
    bool isEmpty() const { return offers.empty() && places_.empty(); }
    /// Calls `visit(seed)` for the places of the first `num_parts` parts.
    template <typename Visit>
    void forEachOf(int num_parts, Visit visit) const {
      std::for_each(places_.begin(), places_.begin() + begin(num_parts), visit);
    }
    /// @returns whether they are others than before.
    bool replace(int part, const std::vector<PlaceSeed>& places);

   private:
    std::ptrdiff_t begin(int part) const;

    std::vector<PlaceSeed> places_;
    std::array<std::uint16_t, kNumParts> counts_{};  ///< of `places_`, by part
  };
  struct Candidate {
    Column column;
    const SpaceCell* cell = nullptr;
    PlaceSeed seed{};
  };

  bool isPlan() const { return config_.free_space == FreeSpaceKind::kWalkable; }
  std::vector<Candidate> collect(const SpaceMap& space, const GridIndex& coarse) const;
  std::vector<PlaceSeed> findOffers(const SpaceMap& space, const GridIndex& coarse) const;
  std::vector<PlaceSeed> findKept(const SpaceMap& space, const GridIndex& coarse) const;
  std::vector<PlaceSeed> fill(const SpaceMap& space, const GridIndex& coarse, int step) const;
  bool isCovered(const SpaceMap& space, const Candidate& candidate, const PlaceSeed& place,
                 bool is_trace) const;
  std::vector<Candidate> findOpen(const SpaceMap& space, const GridIndex& coarse,
                                  bool is_trace) const;
  int mergeRings() const;
  bool replace(const GridIndex& at, int part, const std::vector<PlaceSeed>& places);

  PlacesConfig config_;
  std::unordered_map<GridIndex, Cell, mapping::GridIndexHash> cells_;
};

}  // namespace tsg::places
