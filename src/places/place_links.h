// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "place_cells.h"
#include "space_map.h"

namespace tsg::places {

/// The graph of places.
///
/// Two places at most `max_edge_m` apart, with `min_edge_clearance_m` along the straight line
/// between them, see each other. Such a pair gets an edge unless a third place that both see,
/// nearer to each than they are to one another, makes a way of at most `edge_stretch` times their
/// distance (elliptic Gabriel graph). So every pair that sees each other is joined by a way hardly
/// longer than its distance, and no part of the graph falls off.
///
/// Neither the way of the body nor the Voronoi diagram is cut: each of their cells belongs to the
/// nearest place that it reaches (PlaceCells::reaches()), and the places of neighbouring cells are
/// joined: where neither sees the other nor both see a third nearby, by an edge with the clearance
/// along it, for the way however small; where the line between them is not free the cells
/// themselves become places.
///
/// Parts with places in fewer than `min_component_size` coarse cells are left out unless the body
/// was there. All rules are local, so the result of updates is that of a computation from scratch.
class PlaceLinks {
 public:
  /// Another place as one sees it. Most of the graph's memory: places lie in the middle of voxels,
  /// so the offset gives the length as well, and as max_edge_m is at most 10 m it fits 16 bits.
  struct Link {
    std::array<std::int16_t, 3> offset{};  ///< voxels, from the one place's key to the other's
    bool is_edge = false;
    float clearance_m = 0.0F;

    GridIndex toVector() const { return {offset[0], offset[1], offset[2]}; }
    double length() const { return std::sqrt(toVector().squaredNorm()); }  ///< in voxels
  };
  /// An edge along the way of the body or the diagram, between places that do not see each other.
  struct Walked {
    GridIndex to;  ///< key of the other place
    int num_tiles = 0;
    double clearance_m = 0.0;
  };
  struct Node {
    PlaceSeed seed;              ///< its cell is the node's key
    bool is_place = false;       ///< of PlaceCells; else only a corner
    bool is_kept = false;        ///< belongs to a part that is large enough, or was walked
    int num_corners = 0;         ///< tiles in which the way bends here
    int num_anchored = 0;        ///< tiles with a cell of the way that belongs to it
    std::uint64_t seen_at = 0;   ///< the update that computed `seen`
    std::vector<Link> seen;      ///< places that it sees, ascending by key
    std::vector<Walked> walked;  ///< ascending by key

    GridIndex keyOf(const Link& link) const { return seed.cell + link.toVector(); }
    /// Calls `visit(key, clearance_m)` for the places at its edges.
    template <typename Visit>
    void forEachEdge(Visit visit) const {
      for (const Link& link : seen) {
        if (link.is_edge) visit(keyOf(link), static_cast<double>(link.clearance_m));
      }
      for (const Walked& edge : walked) visit(edge.to, edge.clearance_m);
    }
  };
  using Nodes = std::unordered_map<GridIndex, Node, mapping::GridIndexHash>;

  explicit PlaceLinks(const PlacesConfig& config) : config_(config) {}

  /// @param changed  coarse cells whose places or free space changed
  /// @returns the keys of all places that came, went or may have another clearance or other edges.
  /// O(changed coarse cells and those within an edge's length).
  CellSet update(const SpaceMap& space, const PlaceCells& cells, const CoarseSet& changed);

  /// Null if there is none.
  const Node* find(const GridIndex& key) const {
    const auto found = nodes_.find(key);
    return found == nodes_.end() ? nullptr : &found->second;
  }
  const Nodes& nodes() const { return nodes_; }

 private:
  struct WalkLink {
    GridIndex a;
    GridIndex b;
    double clearance_m = 0.0;
  };
  /// What the way in one tile adds.
  struct Walk {
    std::vector<WalkLink> links;
    std::vector<PlaceSeed> corners;
    std::vector<GridIndex> anchors;  ///< each once
  };

  class Anchors;
  class ChangedArea;

  TileSet findTiles(const SpaceMap& space, const CoarseSet& coarse) const;
  TileSet findTilesAround(const SpaceMap& space, const PlaceCells& cells,
                          const CoarseSet& coarse) const;
  void removeWalks(const TileSet& tiles, CellSet& touched);
  void replaceNodes(const PlaceCells& cells, const CoarseSet& changed, CellSet& touched);
  CellSet updateSeen(const SpaceMap& space, const PlaceCells& cells, const CoarseSet& changed);
  std::vector<Link> computeSeen(const SpaceMap& space, const PlaceCells& cells,
                                const ChangedArea& area, const Node& node) const;
  CellSet updateLinks(const CellSet& others);
  bool hasDetour(const Node& a, const Link& link) const;
  Walk computeWalk(const SpaceMap& space, const PlaceCells& cells, const TileIndex& index,
                   Anchors& anchors) const;
  const Node* findAnchor(const SpaceMap& space, const PlaceCells& cells, const SpaceCell& cell,
                         const PlaceSeed& at) const;
  bool isJoined(const Node& a, const Node& b, double length) const;
  void join(const SpaceMap& space, const PlaceSeed& from, const PlaceSeed& to, const Node& a,
            const Node& b, double min_clearance_m, Walk& walk) const;
  void releaseLink(const GridIndex& from, const GridIndex& to);
  void eraseUnused(const GridIndex& key);
  void addWalk(const TileIndex& index, Walk walk, CellSet& touched);
  void updateKept(const PlaceCells& cells, CellSet& touched);

  PlacesConfig config_;
  std::uint64_t num_updates_ = 0;
  Nodes nodes_;
  std::unordered_map<TileIndex, Walk, TileIndexHash> walks_;
  std::unordered_map<GridIndex, std::vector<GridIndex>, mapping::GridIndexHash> keys_of_coarse_;
};

}  // namespace tsg::places
