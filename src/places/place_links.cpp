// SPDX-License-Identifier: BSD-3-Clause
#include "place_links.h"

#include <algorithm>
#include <cmath>

namespace tsg::places {
namespace {

/// Two places along a trace are joined if a way over a third is at most so many times as long.
constexpr double kMaxDetour = 1.25;

/// How a place sees another; null if it does not.
const PlaceLinks::Link* findLink(const PlaceLinks::Node& node, const GridIndex& key) {
  const GridIndex offset = key - node.seed.cell;
  const auto found = std::lower_bound(
      node.seen.begin(), node.seen.end(), offset,
      [](const PlaceLinks::Link& a, const GridIndex& b) { return CellOrder{}(a.toVector(), b); });
  return found != node.seen.end() && found->toVector() == offset ? &*found : nullptr;
}

PlaceLinks::Link makeLink(const GridIndex& offset, float clearance_m) {
  PlaceLinks::Link link;
  for (int axis = 0; axis < 3; ++axis) {
    link.offset[static_cast<std::size_t>(axis)] = static_cast<std::int16_t>(offset[axis]);
  }
  link.clearance_m = clearance_m;
  return link;
}

/// The edge to a place in a list that ascends by key, or where it belongs.
std::vector<PlaceLinks::Walked>::iterator findWalked(std::vector<PlaceLinks::Walked>& walked,
                                                     const GridIndex& to) {
  return std::lower_bound(
      walked.begin(), walked.end(), to,
      [](const PlaceLinks::Walked& a, const GridIndex& b) { return CellOrder{}(a.to, b); });
}

/// Whether two lists have the same places, whatever the clearance towards them.
bool seesTheSame(const std::vector<PlaceLinks::Link>& a, const std::vector<PlaceLinks::Link>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const PlaceLinks::Link& left, const PlaceLinks::Link& right) {
                      return left.offset == right.offset;
                    });
}

/// The same for both directions.
FreeLine followBetween(const SpaceMap& space, const PlaceSeed& a, const PlaceSeed& b,
                       double min_clearance_m = 0.0) {
  const bool is_first = CellOrder{}(a.cell, b.cell);
  return followLine(space, is_first ? a : b, is_first ? b : a, min_clearance_m);
}

/// Calls `visit(column, cell)` for the free cells beside one, of each pair of neighbours once.
template <typename Visit>
void forEachNext(const SpaceMap& space, const Column& column, const SpaceCell& cell, Visit visit) {
  const auto level_m = static_cast<double>(cell.level_m);
  if (space.isPlan()) {
    // steps of the way may differ by a step in either direction
    const double tolerance_m = (cell.is_axis ? 2.0 : 1.0) * space.maxStep();
    for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {1, 1}, {-1, 1}}) {
      const Column beside{column.x + dx, column.y + dy};
      const SpaceCell* next = space.findFree(beside, level_m, tolerance_m);
      if (next != nullptr) visit(beside, *next);
      if (!cell.is_axis) continue;
      // ground that was seen beside the way, or under it, may be nearer than the way itself
      space.forEachAxis(beside, level_m, tolerance_m, [&](const SpaceCell& axis) {
        if (&axis != next) visit(beside, axis);
      });
    }
    return;
  }
  for (int i = 14; i < 27; ++i) {
    const Column beside{column.x + i % 3 - 1, column.y + i / 3 % 3 - 1};
    const double next_m = level_m + (i / 9 - 1) * space.voxelSize();
    const SpaceCell* next = space.findFree(beside, next_m, 0.5 * space.voxelSize());
    if (next != nullptr) visit(beside, *next);
  }
}

}  // namespace

/// The anchors of cells of traces, each looked for once.
class PlaceLinks::Anchors {
 public:
  Anchors(const PlaceLinks& links, const SpaceMap& space, const PlaceCells& cells)
      : links_(links), space_(space), cells_(cells) {}

  const Node* find(const SpaceCell& cell, const PlaceSeed& at) {
    const auto [found, is_new] = anchor_of_.try_emplace(&cell, nullptr);
    if (is_new) found->second = links_.findAnchor(space_, cells_, cell, at);
    return found->second;
  }

 private:
  const PlaceLinks& links_;
  const SpaceMap& space_;
  const PlaceCells& cells_;
  std::unordered_map<const SpaceCell*, const Node*> anchor_of_;
};

/// Which lines may have changed: those whose bounding box, in the plane, meets a changed coarse
/// cell. Of each island of such cells the counts, summed from its corner.
class PlaceLinks::ChangedArea {
 public:
  explicit ChangedArea(const CoarseSet& changed) {
    TileSet columns;
    for (const GridIndex& at : changed) columns.insert({at.x(), at.y()});
    for (const auto& island : splitIntoIslands({columns.begin(), columns.end()}, kMinGap)) {
      islands_.emplace_back(island);
    }
  }

  /// @param a, b  coarse cells of a line's ends
  bool meets(const GridIndex& a, const GridIndex& b) const {
    const GridIndex low = a.cwiseMin(b);
    const GridIndex high = a.cwiseMax(b);
    return std::any_of(islands_.begin(), islands_.end(),
                       [&](const Island& island) { return island.meets(low, high); });
  }

 private:
  static constexpr int kMinGap = 64;        ///< coarse cells between islands
  static constexpr double kMaxCells = 1e6;  ///< of larger boxes everything counts as changed

  class Island {
   public:
    explicit Island(const std::vector<TileIndex>& columns)
        : min_(columns.front()), max_(columns.front()) {
      for (const auto& [x, y] : columns) {
        min_ = {std::min(min_.first, x), std::min(min_.second, y)};
        max_ = {std::max(max_.first, x), std::max(max_.second, y)};
      }
      const double num_cells = (max_.first - min_.first + 2.0) * (max_.second - min_.second + 2.0);
      if (num_cells > kMaxCells) return;
      sums_.assign(static_cast<std::size_t>(num_cells), 0);
      for (const auto& [x, y] : columns) sums_[toLinear(x + 1, y + 1)] = 1;
      for (int y = min_.second; y <= max_.second; ++y) {
        for (int x = min_.first; x <= max_.first; ++x) {
          sums_[toLinear(x + 1, y + 1)] +=
              sums_[toLinear(x, y + 1)] + sums_[toLinear(x + 1, y)] - sums_[toLinear(x, y)];
        }
      }
    }

    bool meets(const GridIndex& low, const GridIndex& high) const {
      const int x0 = std::max(low.x(), min_.first);
      const int y0 = std::max(low.y(), min_.second);
      const int x1 = std::min(high.x(), max_.first);
      const int y1 = std::min(high.y(), max_.second);
      if (x0 > x1 || y0 > y1) return false;
      if (sums_.empty()) return true;
      return sums_[toLinear(x1 + 1, y1 + 1)] - sums_[toLinear(x0, y1 + 1)] -
                 sums_[toLinear(x1 + 1, y0)] + sums_[toLinear(x0, y0)] >
             0;
    }

   private:
    std::size_t toLinear(int x, int y) const {
      return static_cast<std::size_t>(x - min_.first) +
             static_cast<std::size_t>(max_.first - min_.first + 2) *
                 static_cast<std::size_t>(y - min_.second);
    }

    TileIndex min_;
    TileIndex max_;
    std::vector<int> sums_;
  };

  std::vector<Island> islands_;
};

CellSet PlaceLinks::update(const SpaceMap& space, const PlaceCells& cells,
                           const CoarseSet& changed) {
  ++num_updates_;
  CellSet touched;
  TileSet tiles = findTilesAround(space, cells, changed);
  removeWalks(tiles, touched);
  replaceNodes(cells, changed, touched);
  const CellSet others = updateSeen(space, cells, changed);
  const CellSet with_links = updateLinks(others);
  touched.insert(with_links.begin(), with_links.end());

  CoarseSet around_others;
  for (const GridIndex& key : others) {
    const auto node = nodes_.find(key);
    if (node == nodes_.end()) continue;
    around_others.insert(cells.computeCoarse(node->second.seed.position_m));
  }
  TileSet more;
  for (const TileIndex& index : findTilesAround(space, cells, around_others)) {
    if (tiles.insert(index).second) more.insert(index);
  }
  removeWalks(more, touched);
  std::vector<std::pair<TileIndex, Walk>> walks;
  Anchors anchors(*this, space, cells);
  for (const TileIndex& index : tiles) {
    walks.emplace_back(index, computeWalk(space, cells, index, anchors));
  }
  for (auto& [index, walk] : walks) addWalk(index, std::move(walk), touched);
  updateKept(cells, touched);
  return touched;
}

/// Tiles with cells of traces that may belong to a place in these coarse cells, or be joined
/// through their free space: within the distance at which a cell belongs to a place, and the next
/// cell.
TileSet PlaceLinks::findTilesAround(const SpaceMap& space, const PlaceCells& cells,
                                    const CoarseSet& coarse) const {
  const double reach_m = cells.spacing() + 3.0 * space.voxelSize();
  const auto rings = static_cast<int>(std::ceil(reach_m / config_.cell_size_m));
  return findTiles(space, cells.widen(coarse, rings));
}

/// Tiles that meet coarse cells.
TileSet PlaceLinks::findTiles(const SpaceMap& space, const CoarseSet& coarse) const {
  const double tile_m = kTileSide * space.voxelSize();
  TileSet tiles;
  for (const GridIndex& at : coarse) {
    const auto toTile = [&](int coordinate) {
      return static_cast<int>(std::floor(coordinate * config_.cell_size_m / tile_m));
    };
    for (int x = toTile(at.x()); x <= toTile(at.x() + 1); ++x) {
      for (int y = toTile(at.y()); y <= toTile(at.y() + 1); ++y) {
        if (space.find({x, y}) != nullptr || walks_.count({x, y}) > 0) tiles.insert({x, y});
      }
    }
  }
  return tiles;
}

void PlaceLinks::removeWalks(const TileSet& tiles, CellSet& touched) {
  for (const TileIndex& index : tiles) {
    const auto found = walks_.find(index);
    if (found == walks_.end()) continue;
    const Walk walk = std::move(found->second);
    walks_.erase(found);
    for (const WalkLink& link : walk.links) {
      releaseLink(link.a, link.b);
      releaseLink(link.b, link.a);
      touched.insert({link.a, link.b});
    }
    for (const GridIndex& key : walk.anchors) --nodes_.at(key).num_anchored;
    touched.insert(walk.anchors.begin(), walk.anchors.end());
    for (const PlaceSeed& corner : walk.corners) {
      --nodes_.at(corner.cell).num_corners;
      eraseUnused(corner.cell);
      touched.insert(corner.cell);
    }
  }
}

void PlaceLinks::releaseLink(const GridIndex& from, const GridIndex& to) {
  auto& walked = nodes_.at(from).walked;
  const auto edge = findWalked(walked, to);
  if (--edge->num_tiles == 0) walked.erase(edge);
}

void PlaceLinks::eraseUnused(const GridIndex& key) {
  const auto node = nodes_.find(key);
  if (node != nodes_.end() && !node->second.is_place && node->second.num_corners == 0) {
    nodes_.erase(node);
  }
}

void PlaceLinks::replaceNodes(const PlaceCells& cells, const CoarseSet& changed, CellSet& touched) {
  for (const GridIndex& coarse : changed) {
    auto& keys = keys_of_coarse_[coarse];
    const std::vector<GridIndex> old = std::move(keys);
    keys.clear();
    for (const GridIndex& key : old) nodes_.at(key).is_place = false;
    for (const PlaceSeed& seed : cells.placesAt(coarse)) {
      Node& node = nodes_[seed.cell];
      node.seed = seed;
      node.is_place = true;
      keys.push_back(seed.cell);
    }
    touched.insert(old.begin(), old.end());
    touched.insert(keys.begin(), keys.end());
    for (const GridIndex& key : old) {
      Node& node = nodes_.at(key);
      if (node.is_place) continue;
      node.seen.clear();
      eraseUnused(key);
    }
    if (keys.empty()) keys_of_coarse_.erase(coarse);
  }
}

/// @returns the places that see others than before
CellSet PlaceLinks::updateSeen(const SpaceMap& space, const PlaceCells& cells,
                               const CoarseSet& changed) {
  const auto rings = static_cast<int>(std::ceil(config_.max_edge_m / config_.cell_size_m));
  const ChangedArea area(changed);
  CellSet others;
  for (const GridIndex& coarse : cells.widen(changed, rings)) {
    for (const PlaceSeed& seed : cells.placesAt(coarse)) {
      Node& node = nodes_.at(seed.cell);
      std::vector<Link> seen = computeSeen(space, cells, area, node);
      node.seen_at = num_updates_;
      if (!seesTheSame(node.seen, seen)) {  // its edges are chosen anew
        others.insert(seed.cell);
        for (const Link& link : node.seen) others.insert(node.keyOf(link));
      } else {
        for (std::size_t i = 0; i < seen.size(); ++i) seen[i].is_edge = node.seen[i].is_edge;
      }
      node.seen = std::move(seen);
    }
  }
  return others;
}

/// Lines that did not change are taken over from before, or from the other place's where that was
/// done already.
std::vector<PlaceLinks::Link> PlaceLinks::computeSeen(const SpaceMap& space,
                                                      const PlaceCells& cells,
                                                      const ChangedArea& area,
                                                      const Node& node) const {
  const GridIndex& key = node.seed.cell;
  const GridIndex own = cells.computeCoarse(node.seed.position_m);
  std::vector<Link> seen;
  for (const Link& link : node.seen) {
    const Eigen::Vector3d p_m = (node.keyOf(link).cast<double>().array() + 0.5) * space.voxelSize();
    if (!area.meets(own, cells.computeCoarse(p_m))) seen.push_back(link);
  }
  const auto isWanted = [&](const GridIndex& coarse) { return area.meets(own, coarse); };
  cells.forEachNear(
      node.seed.position_m, config_.max_edge_m, isWanted, [&](const PlaceSeed& other) {
        if (other.cell == key) return;
        const GridIndex offset = other.cell - key;
        const Node& there = nodes_.at(other.cell);
        if (there.seen_at == num_updates_) {
          const Link* link = findLink(there, key);
          if (link != nullptr) seen.push_back(makeLink(offset, link->clearance_m));
          return;
        }
        const FreeLine line = followBetween(space, node.seed, other, config_.min_edge_clearance_m);
        if (!line.is_free) return;
        seen.push_back(makeLink(offset, static_cast<float>(line.clearance_m)));
      });
  std::sort(seen.begin(), seen.end(),
            [](const Link& a, const Link& b) { return CellOrder{}(a.toVector(), b.toVector()); });
  seen.shrink_to_fit();
  return seen;
}

/// Edges anew of places that see others than before, and of those that they see.
/// @returns the places whose edges were chosen anew
CellSet PlaceLinks::updateLinks(const CellSet& others) {
  CellSet chosen;
  for (const GridIndex& key : others) {
    const auto node = nodes_.find(key);
    if (node == nodes_.end()) continue;
    chosen.insert(key);
    for (const Link& link : node->second.seen) chosen.insert(node->second.keyOf(link));
  }
  for (const GridIndex& key : chosen) {
    Node& node = nodes_.at(key);
    for (Link& link : node.seen) link.is_edge = !hasDetour(node, link);
  }
  return chosen;
}

bool PlaceLinks::hasDetour(const Node& a, const Link& link) const {
  const Node& b = nodes_.at(a.keyOf(link));
  const GridIndex whole = link.toVector();
  const int squared = whole.squaredNorm();  // of lengths in voxels
  const double longest = config_.edge_stretch * link.length();
  return std::any_of(a.seen.begin(), a.seen.end(), [&](const Link& first) {
    const int first_squared = first.toVector().squaredNorm();
    const int second_squared = (whole - first.toVector()).squaredNorm();
    return first_squared < squared && second_squared < squared &&
           std::sqrt(first_squared) + std::sqrt(second_squared) <= longest &&
           findLink(b, a.keyOf(first)) != nullptr;
  });
}

/// The place that a cell of a trace belongs to; null if it reaches none.
const PlaceLinks::Node* PlaceLinks::findAnchor(const SpaceMap& space, const PlaceCells& cells,
                                               const SpaceCell& cell, const PlaceSeed& at) const {
  std::vector<std::pair<double, const PlaceSeed*>> near;
  const auto isAny = [](const GridIndex&) { return true; };
  cells.forEachNear(at.position_m, cells.spacing(), isAny, [&](const PlaceSeed& seed) {
    near.emplace_back((seed.position_m - at.position_m).norm(), &seed);
  });
  std::sort(near.begin(), near.end(), [](const auto& a, const auto& b) {
    return a.first == b.first ? CellOrder{}(a.second->cell, b.second->cell) : a.first < b.first;
  });
  for (const auto& [distance_m, seed] : near) {
    if (cells.reaches(space, cell, at, *seed)) return &nodes_.at(seed->cell);
  }
  return nullptr;
}

/// Joins the places of neighbouring cells of traces, in this tile and with those beside it.
PlaceLinks::Walk PlaceLinks::computeWalk(const SpaceMap& space, const PlaceCells& cells,
                                         const TileIndex& index, Anchors& anchors) const {
  Walk walk;
  const SpaceTile* tile = space.find(index);
  if (tile == nullptr) return walk;
  for (const SpaceCell& cell : tile->cells) {
    if (!isTrace(cell)) continue;
    const Column column = computeColumn(index, cell.offset);
    const PlaceSeed from = cells.makeSeed(space, column, cell);
    const Node* a = anchors.find(cell, from);
    if (a == nullptr) continue;
    if (cell.is_axis) walk.anchors.push_back(a->seed.cell);
    forEachNext(space, column, cell, [&](const Column& beside, const SpaceCell& next) {
      const bool is_way = cell.is_axis && next.is_axis;
      if (!is_way && !(cell.is_voronoi && next.is_voronoi)) return;
      const PlaceSeed to = cells.makeSeed(space, beside, next);
      const Node* b = anchors.find(next, to);
      if (b == nullptr || a == b) return;
      const double length_m = (from.position_m - a->seed.position_m).norm() +
                              (to.position_m - from.position_m).norm() +
                              (b->seed.position_m - to.position_m).norm();
      if (isJoined(*a, *b, length_m / space.voxelSize())) return;
      join(space, from, to, *a, *b, is_way ? 0.0 : config_.min_edge_clearance_m, walk);
    });
  }
  std::sort(walk.anchors.begin(), walk.anchors.end(), CellOrder{});
  walk.anchors.erase(std::unique(walk.anchors.begin(), walk.anchors.end()), walk.anchors.end());
  walk.anchors.shrink_to_fit();
  return walk;
}

/// True if one sees the other, or both a third that is not far off the way of `length` voxels
/// between.
bool PlaceLinks::isJoined(const Node& a, const Node& b, double length) const {
  if (findLink(a, b.seed.cell) != nullptr) return true;
  return std::any_of(a.seen.begin(), a.seen.end(), [&](const Link& first) {
    const Link* second = findLink(b, a.keyOf(first));
    return second != nullptr && first.length() + second->length() <= kMaxDetour * length;
  });
}

/// @param from  cell of a trace that belongs to `a`
/// @param to    a neighbouring one, of `b`
void PlaceLinks::join(const SpaceMap& space, const PlaceSeed& from, const PlaceSeed& to,
                      const Node& a, const Node& b, double min_clearance_m, Walk& walk) const {
  const FreeLine line = followBetween(space, a.seed, b.seed);
  if (line.is_free && line.clearance_m >= min_clearance_m) {
    walk.links.push_back({a.seed.cell, b.seed.cell, line.clearance_m});
    return;
  }
  const auto narrow = [&](const PlaceSeed& p, const PlaceSeed& q) {
    const FreeLine between = followBetween(space, p, q);
    const float ends_m = std::min(p.clearance_m, q.clearance_m);
    return between.is_free ? between.clearance_m : static_cast<double>(ends_m);
  };
  for (const PlaceSeed& corner : {from, to}) walk.corners.push_back(corner);
  const auto add = [&](const PlaceSeed& p, const PlaceSeed& q) {
    if (p.cell != q.cell) walk.links.push_back({p.cell, q.cell, narrow(p, q)});
  };
  add(a.seed, from);
  add(from, to);
  add(to, b.seed);
}

void PlaceLinks::addWalk(const TileIndex& index, Walk walk, CellSet& touched) {
  if (walk.anchors.empty() && walk.links.empty()) return;
  for (const PlaceSeed& corner : walk.corners) {
    Node& node = nodes_[corner.cell];
    if (!node.is_place) node.seed = corner;
    ++node.num_corners;
    touched.insert(corner.cell);
  }
  for (const WalkLink& link : walk.links) {
    for (const auto& [from, to] : {std::pair{link.a, link.b}, {link.b, link.a}}) {
      auto& walked = nodes_.at(from).walked;
      auto edge = findWalked(walked, to);
      if (edge == walked.end() || edge->to != to) edge = walked.insert(edge, Walked{to, 0, 0.0});
      ++edge->num_tiles;
      edge->clearance_m = link.clearance_m;
      touched.insert(from);
    }
  }
  for (const GridIndex& key : walk.anchors) {
    ++nodes_.at(key).num_anchored;
    touched.insert(key);
  }
  walks_[index] = std::move(walk);
}

/// Parts are followed until they are large enough; of those that are, places that did not count
/// before are told.
void PlaceLinks::updateKept(const PlaceCells& cells, CellSet& touched) {
  CellSet decided;
  const CellSet seeds = touched;
  for (const GridIndex& seed : seeds) {
    if (nodes_.count(seed) == 0 || decided.count(seed) > 0) continue;
    std::vector<GridIndex> part{seed};
    CellSet is_seen{seed};
    CoarseSet coarse;
    bool is_kept = false;
    for (std::size_t i = 0; i < part.size(); ++i) {
      const Node& node = nodes_.at(part[i]);
      coarse.insert(cells.computeCoarse(node.seed.position_m));
      is_kept = is_kept || node.num_anchored > 0 ||
                static_cast<int>(coarse.size()) >= config_.min_component_size;
      node.forEachEdge([&](const GridIndex& next, double) {
        const bool is_told = is_kept && nodes_.at(next).is_kept && seeds.count(next) == 0;
        if (!is_told && is_seen.insert(next).second) part.push_back(next);
      });
    }
    for (const GridIndex& key : part) {
      Node& node = nodes_.at(key);
      decided.insert(key);
      if (node.is_kept == is_kept) continue;
      node.is_kept = is_kept;
      touched.insert(key);
    }
  }
}

}  // namespace tsg::places
