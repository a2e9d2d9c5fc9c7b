// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/places/sparse_graph.h"

#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "task_scene_graph/places/near_pairs.h"
#include "union_find.h"

namespace tsg::places {
namespace {

constexpr std::int32_t kNoSet = -1;
using IndexPair = std::pair<std::size_t, std::size_t>;

IndexPair ordered(std::size_t a, std::size_t b) {
  return a < b ? IndexPair{a, b} : IndexPair{b, a};
}

/// Calls `visit(neighbour)` for the up to 26 cells around one.
template <typename Visit>
void forEachNeighbour(const GridExtent& extent, std::size_t cell, Visit visit) {
  const GridIndex at = extent.toIndex(cell);
  for (int i = 0; i < 27; ++i) {
    const GridIndex next = at + GridIndex(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (i != 13 && extent.contains(next)) visit(extent.toLinear(next));
  }
}

GridIndex computeCoarseCell(const FreeSpace& space, std::size_t cell, double cell_size_m) {
  const Eigen::Vector3d center = space.extent.toIndex(cell).cast<double>().array() + 0.5;
  return (center * (space.voxel_size_m / cell_size_m)).array().floor().cast<int>();
}

/// Partition of the Voronoi cells into connected sets that each lie in one coarse cell.
class VoronoiSets {
 public:
  VoronoiSets(const FreeSpace& space, const std::vector<char>& is_voronoi, double cell_size_m)
      : space_(space), cell_size_m_(cell_size_m), set_of_(is_voronoi.size(), kNoSet) {
    for (std::size_t cell = 0; cell < is_voronoi.size(); ++cell) {
      if (is_voronoi[cell] != 0 && set_of_[cell] == kNoSet) grow(cell, is_voronoi);
    }
  }

  const std::vector<std::vector<std::size_t>>& sets() const { return sets_; }

  /// Pairs of sets with neighbouring cells, ascending.
  std::set<IndexPair> findTouching() const {
    std::set<IndexPair> touching;
    for (std::size_t s = 0; s < sets_.size(); ++s) {
      for (const std::size_t cell : sets_[s]) {
        forEachNeighbour(space_.extent, cell, [&](std::size_t next) {
          if (set_of_[next] == kNoSet) return;
          const auto other = static_cast<std::size_t>(set_of_[next]);
          if (s < other) touching.insert({s, other});
        });
      }
    }
    return touching;
  }

 private:
  void grow(std::size_t seed, const std::vector<char>& is_voronoi) {
    const auto id = static_cast<std::int32_t>(sets_.size());
    const GridIndex coarse = computeCoarseCell(space_, seed, cell_size_m_);
    std::vector<std::size_t> cells{seed};
    set_of_[seed] = id;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      forEachNeighbour(space_.extent, cells[i], [&](std::size_t next) {
        if (is_voronoi[next] == 0 || set_of_[next] != kNoSet ||
            computeCoarseCell(space_, next, cell_size_m_) != coarse)
          return;
        set_of_[next] = id;
        cells.push_back(next);
      });
    }
    sets_.push_back(std::move(cells));
  }

  const FreeSpace& space_;
  double cell_size_m_;
  std::vector<std::int32_t> set_of_;
  std::vector<std::vector<std::size_t>> sets_;
};

/// The cell with the largest clearance; among equals the one nearest to the set's middle.
SparsePlace choosePlace(const FreeSpace& space, const std::vector<std::size_t>& cells) {
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  for (const std::size_t cell : cells) middle_m += space.computePosition(cell);
  middle_m /= static_cast<double>(cells.size());
  SparsePlace best;
  double best_offset_m = 0.0;
  for (const std::size_t cell : cells) {
    const SparsePlace place{cell, space.computePosition(cell),
                            static_cast<double>(space.clearance_m[cell])};
    const double offset_m = (place.position_m - middle_m).norm();
    const bool is_nearer = place.clearance_m == best.clearance_m && offset_m < best_offset_m;
    if (place.clearance_m <= best.clearance_m && !is_nearer) continue;
    best = place;
    best_offset_m = offset_m;
  }
  return best;
}

/// Builds the graph step by step; places are addressed by set until the end.
class GraphBuilder {
 public:
  GraphBuilder(const FreeSpace& space, const PlacesConfig& config)
      : space_(space), config_(config) {}

  SparseGraph build(const std::vector<char>& is_voronoi) {
    const VoronoiSets sets(space_, is_voronoi, config_.cell_size_m);
    for (const auto& cells : sets.sets()) places_.push_back(choosePlace(space_, cells));
    const std::set<IndexPair> touching = sets.findTouching();
    mergeNearPlaces(touching);
    const std::size_t num_sets = places_.size();
    if (space_.isPlan() && config_.fill_distance_m > 0.0) addFillPlaces();
    UnionFind parts(places_.size());
    for (const auto& [a, b] : touching) addEdge(merged_.find(a), merged_.find(b), parts);
    addFillEdges(num_sets, parts);
    addBridges(parts);
    return collect(parts);
  }

 private:
  double computeDistance(std::size_t a, std::size_t b) const {
    return (places_[a].position_m - places_[b].position_m).norm();
  }

  /// Nearest first; the place with the larger clearance stays.
  void mergeNearPlaces(const std::set<IndexPair>& touching) {
    merged_ = UnionFind(places_.size());
    std::set<std::pair<double, IndexPair>> by_distance;
    for (const IndexPair& pair : touching) {
      by_distance.insert({computeDistance(pair.first, pair.second), pair});
    }
    for (const auto& [distance_m, pair] : by_distance) {
      const auto [a, b] = ordered(merged_.find(pair.first), merged_.find(pair.second));
      if (a == b || computeDistance(a, b) >= config_.merge_distance_m) continue;
      const bool is_first = places_[a].clearance_m >= places_[b].clearance_m;
      merged_.attach(is_first ? b : a, is_first ? a : b);
    }
  }

  void addEdge(std::size_t a, std::size_t b, UnionFind& parts) {
    if (a == b || edges_.count(ordered(a, b)) > 0) return;
    const double clearance_m = computeLineClearance(space_, places_[a].cell, places_[b].cell);
    if (clearance_m <= 0.0 || clearance_m < config_.min_edge_clearance_m) return;
    edges_[ordered(a, b)] = clearance_m;
    parts.attach(parts.find(b), parts.find(a));
  }

  /// One place in every coarse cell that has open space far from all places, nearest its middle.
  void addFillPlaces() {
    std::vector<SparsePlace> kept;
    for (const std::size_t s : findKept()) kept.push_back(places_[s]);
    const std::vector<SparsePlace> added = findFillPlaces(space_, kept, config_);
    places_.insert(places_.end(), added.begin(), added.end());
    merged_.grow(places_.size());
  }

  /// Joins the places from `first` on to all that are near.
  void addFillEdges(std::size_t first, UnionFind& parts) {
    const std::vector<std::size_t> kept = findKept();
    for (const NearPair& pair : findNearKept(kept, 1.5 * config_.cell_size_m)) {
      const std::size_t a = kept[pair.a];
      const std::size_t b = kept[pair.b];
      if (a < b && b >= first) addEdge(a, b, parts);
    }
  }

  std::vector<std::size_t> findKept() {
    std::vector<std::size_t> kept;
    for (std::size_t s = 0; s < places_.size(); ++s) {
      if (merged_.find(s) == s) kept.push_back(s);
    }
    return kept;
  }

  std::vector<NearPair> findNearKept(const std::vector<std::size_t>& kept,
                                     double max_distance_m) const {
    std::vector<Eigen::Vector3d> positions_m;
    for (const std::size_t s : kept) positions_m.push_back(places_[s].position_m);
    return findNearPairs(positions_m, positions_m, max_distance_m);
  }

  /// Shortest lines first; only between parts that are still apart (Kruskal).
  void addBridges(UnionFind& parts) {
    const std::vector<std::size_t> kept = findKept();
    for (const NearPair& pair : findNearKept(kept, config_.max_bridge_m)) {
      const std::size_t a = kept[pair.a];
      const std::size_t b = kept[pair.b];
      if (a < b && parts.find(a) != parts.find(b)) addEdge(a, b, parts);
    }
  }

  /// The places and edges of all parts that are large enough.
  SparseGraph collect(UnionFind& parts) {
    std::map<std::size_t, int> part_sizes;
    for (std::size_t s = 0; s < places_.size(); ++s) {
      if (merged_.find(s) == s) ++part_sizes[parts.find(s)];
    }
    SparseGraph graph;
    std::map<std::size_t, std::size_t> index_of;
    for (std::size_t s = 0; s < places_.size(); ++s) {
      const bool is_kept = merged_.find(s) == s;
      if (!is_kept || part_sizes.at(parts.find(s)) < config_.min_component_size) continue;
      index_of[s] = graph.places.size();
      graph.places.push_back(places_[s]);
    }
    for (const auto& [pair, clearance_m] : edges_) {
      if (index_of.count(pair.first) == 0) continue;
      graph.edges.push_back({index_of.at(pair.first), index_of.at(pair.second), clearance_m});
    }
    return graph;
  }

  const FreeSpace& space_;
  const PlacesConfig& config_;
  std::vector<SparsePlace> places_;  ///< one per set
  UnionFind merged_{0};              ///< root = the set whose place stands for all
  std::map<IndexPair, double> edges_;
};

}  // namespace

void SparseGraph::append(const SparseGraph& other) {
  const std::size_t first = places.size();
  places.insert(places.end(), other.places.begin(), other.places.end());
  for (const SparseEdge& edge : other.edges) {
    edges.push_back({edge.a + first, edge.b + first, edge.clearance_m});
  }
}

SparseGraph computeSparseGraph(const FreeSpace& space, const std::vector<char>& is_voronoi,
                               const PlacesConfig& config) {
  return GraphBuilder(space, config).build(is_voronoi);
}

}  // namespace tsg::places
