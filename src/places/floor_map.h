// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <map>
#include <set>
#include <unordered_map>
#include <vector>

#include "task_scene_graph/places/places_config.h"
#include "task_scene_graph/places/voxel_map.h"
#include "tiles.h"
#include "way_map.h"

namespace tsg::places {

/// Where a body can stand in a column.
struct GroundNode {
  int offset = 0;         ///< of the column in its tile
  float height_m = 0.0F;  ///< world z of the ground
  bool is_walked = false;
  bool is_axis = false;  ///< the middle of the body was here
  int patch = -1;        ///< that it belongs to; -1 = at the edge of a drop, no floor
  bool is_drop = false;  ///< an edge beside which the ground lies more than 1.5 steps lower
  bool is_ramp = false;  ///< the way climbs here, over steps of which not all need have been seen
};

/// Finds the floors: ground (findGround(), or the body's way where no ground was seen and nothing
/// solid stands in its place) in patches, joined along x and y over steps of at most `max_step_m`.
/// Sure floor = what was walked and what is at least six times `min_floor_area_m2` large. Other
/// floor = what has that area or is at most twice `max_floor_gap_m` beside sure floor, unless it
/// looks down on sure floor from more of its edge than half the root of its area (as beds and
/// tables do). Ground at the upper edge of a drop, or that rises by more than 1.25 steps over three
/// columns, is no floor unless it was walked (noise at the edge of a cabinet can look like a ramp
/// to its top). All are properties of the map alone, so the result of updates is that of a
/// computation from scratch.
class FloorMap {
 public:
  explicit FloorMap(const PlacesConfig& config) : config_(config) {}

  /// Reads ground anew where voxels changed.
  void readGround(const VoxelMap& voxels, const TileSet& changed);
  /// Heights of the observed ground at most `radius_m` from a position, and below it.
  std::vector<float> collectGround(const Eigen::Vector3d& p_m, double radius_m,
                                   double voxel_size_m) const;

  /// Finds floors anew after voxels or the way changed in these tiles.
  /// @returns the tiles whose floor differs from before. O(changed tiles, and for each the patches
  /// around it up to the area of a floor).
  TileSet update(const VoxelMap& voxels, const WayMap& way, const TileSet& changed);

  /// Calls `visit(node)` for the floor of a tile, by column, then by height.
  template <typename Visit>
  void forEachFloor(const TileIndex& index, Visit visit) const {
    const auto found = tiles_.find(index);
    if (found == tiles_.end()) return;
    for (const GroundNode& node : found->second.nodes) {
      if (node.patch >= 0 && found->second.patches[static_cast<std::size_t>(node.patch)].is_floor)
        visit(node);
    }
  }

  /// Calls `visit(node)` for the edges of floor beside which it goes down by more than 1.5 steps
  /// and where nobody walked, by column, then by height.
  template <typename Visit>
  void forEachDrop(const TileIndex& index, Visit visit) const {
    const auto found = tiles_.find(index);
    if (found == tiles_.end()) return;
    for (const GroundNode& node : found->second.nodes) {
      if (node.is_drop && isBesideFloor(computeColumn(index, node.offset), node.height_m))
        visit(node);
    }
  }

 private:
  /// Nodes of one tile that hang together.
  struct Patch {
    int num_nodes = 0;
    bool is_walked = false;
    bool is_sure = false;  ///< part of a floor that was walked or is six times as large as need be
    bool is_floor = false;
  };
  struct Tile {
    std::array<std::vector<float>, kTileColumns> ground_m;  ///< observed
    std::vector<GroundNode> nodes;                          ///< by column, then by height
    std::array<int, kTileColumns + 1> begin{};              ///< of each column in `nodes`
    std::vector<Patch> patches;
  };
  struct PatchRef {
    TileIndex tile;
    int patch = 0;
    friend bool operator<(const PatchRef& a, const PatchRef& b) {
      return a.tile == b.tile ? a.patch < b.patch : a.tile < b.tile;
    }
  };

  bool makeNodes(const VoxelMap& voxels, const WayMap& way, const TileIndex& index);
  void addWay(const VoxelMap& voxels, const WayMap& way, const TileIndex& index,
              std::vector<GroundNode>& nodes) const;
  bool isCliffEdge(const TilesAround<Tile>& around, const Column& column, float height_m,
                   double steps) const;
  bool isBesideFloor(const Column& column, float height_m) const;
  bool isSteep(const TilesAround<Tile>& around, const Column& column, float height_m) const;
  bool makePatches(const TileIndex& index);
  void spreadPatch(Tile& tile, std::size_t seed) const;
  /// Calls `visit(tile, node)` for the nodes of a column that a step reaches.
  template <typename Visit>
  void forEachReached(const Column& column, float height_m, Visit visit) const;
  template <typename Visit>
  void forEachNeighbour(const PatchRef& patch, Visit visit) const;

  bool computeIsSure(const PatchRef& seed, const std::map<PatchRef, bool>& decided,
                     std::vector<PatchRef>& seen) const;
  void spreadSure(std::vector<PatchRef> patches, std::map<PatchRef, bool>& decided,
                  TileSet& changed);
  TileSet updateSure(const TileSet& with_patches);
  TileSet updateFloor(const TileSet& with_sure);
  std::vector<PatchRef> collectComponent(const PatchRef& seed) const;
  bool computeIsFloor(const std::vector<PatchRef>& component) const;
  /// What lies beside a node along x and y, beyond columns without ground.
  struct Beside {
    bool is_floor = false;  ///< sure floor a step away
    bool is_lower = false;  ///< sure floor, farther below
  };
  Beside lookBeside(const Column& column, float height_m, int reach) const;
  void lookAt(const Tile& tile, const Column& column, float height_m, Beside& beside,
              bool& is_level) const;
  int computeGap() const;

  Patch& patchAt(const PatchRef& ref) {
    return tiles_.at(ref.tile).patches[static_cast<std::size_t>(ref.patch)];
  }
  const Patch& patchAt(const PatchRef& ref) const {
    return tiles_.at(ref.tile).patches[static_cast<std::size_t>(ref.patch)];
  }

  PlacesConfig config_;
  double voxel_size_m_ = 0.0;
  std::unordered_map<TileIndex, Tile, TileIndexHash> tiles_;
};

/// World z of every ground in a column: a solid voxel under `body_height_m` of free voxels, the
/// height interpolated between them; ascending.
std::vector<float> findGround(const VoxelMap::Column& column, double voxel_size_m,
                              double body_height_m);

/// The blocks of a tile, which all of its columns are read from.
struct TileVoxels {
  const VoxelMap::BlockColumn* blocks = nullptr;  ///< null: nothing was observed
  double voxel_size_m = 0.0;

  TileVoxels(const VoxelMap& voxels, const TileIndex& tile);
};

/// Distance of the solid voxel nearest to its surface between two heights of a column; kNotObserved
/// if there is none. @param offset  of the column in the tile
float findSolid(const TileVoxels& voxels, int offset, double min_m, double max_m);

/// True if every voxel of the column whose centre lies between two heights was observed free.
bool isFreeBetween(const TileVoxels& voxels, int offset, double min_m, double max_m);

}  // namespace tsg::places
