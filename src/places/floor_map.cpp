// SPDX-License-Identifier: BSD-3-Clause
#include "floor_map.h"

#include <algorithm>
#include <cmath>

namespace tsg::places {
namespace {

bool isBefore(const GroundNode& a, const GroundNode& b) {
  return a.offset == b.offset ? a.height_m < b.height_m : a.offset < b.offset;
}

bool isSame(const GroundNode& a, const GroundNode& b) {
  return a.offset == b.offset && a.height_m == b.height_m && a.is_walked == b.is_walked &&
         a.is_axis == b.is_axis && a.is_ramp == b.is_ramp;
}

/// What was not walked is surely floor from so many times the least area on.
constexpr double kSurelyFloor = 6.0;

/// What goes down by more than so many steps is a drop. With one, steps that were seen in part are.
constexpr double kDropSteps = 1.5;

/// Range of voxel indices whose centres lie between two heights.
struct VoxelRange {
  int first = 0;
  int last = 0;
};

VoxelRange computeRange(double min_m, double max_m, double voxel_size_m) {
  return {static_cast<int>(std::ceil(min_m / voxel_size_m - 0.5)),
          static_cast<int>(std::floor(max_m / voxel_size_m - 0.5))};
}

/// Calls `visit(distance_m)` for the voxels of a column, from below, as far as there are blocks,
/// until it returns false.
template <typename Visit>
void forEachBetween(const TileVoxels& voxels, int offset, const VoxelRange& range, Visit visit) {
  if (voxels.blocks == nullptr) return;
  const auto& blocks = *voxels.blocks;
  for (auto block = blocks.lower_bound(range.first >> 3); block != blocks.end(); ++block) {
    const int base = block->first * mapping::kBlockSide;
    if (base > range.last) return;
    const int last = std::min(range.last, base + mapping::kBlockSide - 1);
    for (int z = std::max(range.first, base); z <= last; ++z) {
      if (!visit((*block->second)[static_cast<std::size_t>(offset + kTileColumns * (z - base))]))
        return;
    }
  }
}

}  // namespace

std::vector<float> findGround(const VoxelMap::Column& column, double voxel_size_m,
                              double body_height_m) {
  const auto body = static_cast<std::size_t>(std::ceil(body_height_m / voxel_size_m));
  const std::vector<float>& distances_m = column.distances_m;
  std::vector<float> heights_m;
  std::size_t num_free = 0;
  for (std::size_t i = distances_m.size(); i-- > 0;) {
    if (isFree(distances_m[i])) {
      ++num_free;
      continue;
    }
    if (isSolid(distances_m[i]) && num_free >= body) {
      const double below_m = static_cast<double>(distances_m[i]);
      const double above_m = static_cast<double>(distances_m[i + 1]);
      const double index =
          column.min_z + static_cast<double>(i) + 0.5 - below_m / (above_m - below_m);
      heights_m.push_back(static_cast<float>(index * voxel_size_m));
    }
    num_free = 0;
  }
  std::reverse(heights_m.begin(), heights_m.end());
  return heights_m;
}

TileVoxels::TileVoxels(const VoxelMap& voxels, const TileIndex& tile)
    : voxel_size_m(voxels.voxelSize()) {
  const auto found = voxels.columns().find(tile);
  if (found != voxels.columns().end()) blocks = &found->second;
}

float findSolid(const TileVoxels& voxels, int offset, double min_m, double max_m) {
  float found = kNotObserved;
  forEachBetween(voxels, offset, computeRange(min_m, max_m, voxels.voxel_size_m),
                 [&](float distance_m) {
                   if (isSolid(distance_m) && !(found >= distance_m)) found = distance_m;
                   return true;
                 });
  return found;
}

bool isFreeBetween(const TileVoxels& voxels, int offset, double min_m, double max_m) {
  const VoxelRange range = computeRange(min_m, max_m, voxels.voxel_size_m);
  int num_free = 0;
  forEachBetween(voxels, offset, range, [&](float distance_m) {
    if (!isFree(distance_m)) return false;
    ++num_free;
    return true;
  });
  return num_free == range.last - range.first + 1;
}

void FloorMap::readGround(const VoxelMap& voxels, const TileSet& changed) {
  voxel_size_m_ = voxels.voxelSize();
  for (const TileIndex& index : changed) {
    Tile& tile = tiles_[index];
    for (auto& column_m : tile.ground_m) column_m.clear();
    voxels.forEachRun(index, [&](int offset, const VoxelMap::Column& column) {
      const auto found_m = findGround(column, voxel_size_m_, config_.body_height_m);
      auto& ground_m = tile.ground_m[static_cast<std::size_t>(offset)];
      for (const float height_m : found_m) {
        ground_m.push_back(roundToStep(height_m, voxel_size_m_));
      }
    });
  }
}

std::vector<float> FloorMap::collectGround(const Eigen::Vector3d& p_m, double radius_m,
                                           double voxel_size_m) const {
  std::vector<float> heights_m;
  const double tile_m = kTileSide * voxel_size_m;
  const auto reach = static_cast<int>(std::ceil(radius_m / tile_m));
  const TileIndex middle{static_cast<int>(std::floor(p_m.x() / tile_m)),
                         static_cast<int>(std::floor(p_m.y() / tile_m))};
  for (int dx = -reach; dx <= reach; ++dx) {
    for (int dy = -reach; dy <= reach; ++dy) {
      const auto found = tiles_.find({middle.first + dx, middle.second + dy});
      if (found == tiles_.end()) continue;
      for (const auto& column_m : found->second.ground_m) {
        for (const float height_m : column_m) {
          if (static_cast<double>(height_m) < p_m.z()) heights_m.push_back(height_m);
        }
      }
    }
  }
  return heights_m;
}

TileSet FloorMap::update(const VoxelMap& voxels, const WayMap& way, const TileSet& changed) {
  voxel_size_m_ = voxels.voxelSize();
  TileSet with_nodes;
  for (const TileIndex& index : changed) {
    if (makeNodes(voxels, way, index)) with_nodes.insert(index);
  }
  TileSet with_patches;
  for (const TileIndex& index : widen(with_nodes, 1)) {
    const bool is_new = with_nodes.count(index) > 0;
    if (tiles_.count(index) > 0 && (makePatches(index) || is_new)) with_patches.insert(index);
  }
  TileSet result = with_patches;
  TileSet with_sure = updateSure(with_patches);
  with_sure.insert(with_patches.begin(), with_patches.end());
  const TileSet with_floor = updateFloor(with_sure);
  result.insert(with_sure.begin(), with_sure.end());
  result.insert(with_floor.begin(), with_floor.end());
  return result;
}

/// @returns whether the nodes differ from before
bool FloorMap::makeNodes(const VoxelMap& voxels, const WayMap& way, const TileIndex& index) {
  Tile& tile = tiles_[index];
  std::vector<GroundNode> nodes;
  for (int i = 0; i < kTileColumns; ++i) {
    for (const float height_m : tile.ground_m[static_cast<std::size_t>(i)]) {
      nodes.push_back({i, height_m, false, false, -1});
    }
  }
  addWay(voxels, way, index, nodes);
  std::sort(nodes.begin(), nodes.end(), isBefore);
  const bool is_same = nodes.size() == tile.nodes.size() &&
                       std::equal(nodes.begin(), nodes.end(), tile.nodes.begin(), isSame);
  if (is_same) return false;
  tile.nodes = std::move(nodes);
  tile.begin.fill(0);
  for (const GroundNode& node : tile.nodes) ++tile.begin[static_cast<std::size_t>(node.offset) + 1];
  for (std::size_t i = 1; i < tile.begin.size(); ++i) tile.begin[i] += tile.begin[i - 1];
  return true;
}

/// Observed ground within a step of the way is walked; where there is none the way itself is
/// ground, except, beside its axis, where something solid stands. Where the way climbs it is ground
/// in place of the steps under it, of which some were seen and some were not: a ramp without gaps.
void FloorMap::addWay(const VoxelMap& voxels, const WayMap& way, const TileIndex& index,
                      std::vector<GroundNode>& nodes) const {
  std::size_t num_observed = nodes.size();  // they come first
  const TileVoxels tile_voxels(voxels, index);
  for (const WayCell& cell : way.cellsAt(index)) {
    const double slope_m = cell.climbs(config_.max_step_m) ? cell.top_m - cell.level_m : 0.0;
    const auto away_m = [&](const GroundNode& node) {
      return std::abs(static_cast<double>(node.height_m) - cell.level_m);
    };
    const auto isUnder = [&](const GroundNode& node) {
      return node.offset == cell.offset && away_m(node) <= config_.max_step_m + slope_m;
    };
    GroundNode* nearest = nullptr;
    for (std::size_t i = 0; slope_m == 0.0 && i < num_observed; ++i) {
      if (!isUnder(nodes[i])) continue;
      if (nearest == nullptr || away_m(nodes[i]) < away_m(*nearest)) nearest = &nodes[i];
    }
    if (nearest != nullptr) {
      nearest->is_walked = true;
      nearest->is_axis = nearest->is_axis || cell.is_axis;
      continue;
    }
    const float solid_m =
        findSolid(tile_voxels, cell.offset, cell.level_m + slope_m + config_.max_step_m,
                  cell.level_m + config_.body_height_m);
    if (!cell.is_axis && isSolid(solid_m)) continue;
    const auto end_observed = nodes.begin() + static_cast<std::ptrdiff_t>(num_observed);
    num_observed -= static_cast<std::size_t>(std::count_if(nodes.begin(), end_observed, isUnder));
    nodes.erase(std::remove_if(nodes.begin(), nodes.end(), isUnder), nodes.end());
    GroundNode node;
    node.offset = cell.offset;
    node.height_m = static_cast<float>(cell.level_m);
    node.is_walked = true;
    node.is_axis = cell.is_axis;
    node.is_ramp = slope_m > 0.0;
    nodes.push_back(node);
  }
}

/// True if a column beside it has ground below and none that so many steps would reach.
bool FloorMap::isCliffEdge(const TilesAround<Tile>& around, const Column& column, float height_m,
                           double steps) const {
  const auto max_step_m = static_cast<float>(steps * config_.max_step_m);
  for (int i = 0; i < 9; ++i) {
    const Column beside{column.x + i % 3 - 1, column.y + i / 3 - 1};
    const Tile* tile = around.find(beside);
    if (tile == nullptr) continue;
    const auto offset = static_cast<std::size_t>(computeOffset(beside));
    bool has_lower = false;
    bool has_level = false;
    for (int n = tile->begin[offset]; n < tile->begin[offset + 1]; ++n) {
      const float rise_m = tile->nodes[static_cast<std::size_t>(n)].height_m - height_m;
      has_level = has_level || std::abs(rise_m) <= max_step_m;
      has_lower = has_lower || rise_m < -max_step_m;
    }
    if (has_lower && !has_level) return true;
  }
  return false;
}

/// True if the ground falls to one side and rises to the other as no stairs do.
bool FloorMap::isSteep(const TilesAround<Tile>& around, const Column& column,
                       float height_m) const {
  const auto max_step_m = static_cast<float>(config_.max_step_m);
  const auto findRise = [&](const Column& beside, float& rise_m) {
    const Tile* tile = around.find(beside);
    if (tile == nullptr) return false;
    const auto offset = static_cast<std::size_t>(computeOffset(beside));
    for (int n = tile->begin[offset]; n < tile->begin[offset + 1]; ++n) {
      rise_m = tile->nodes[static_cast<std::size_t>(n)].height_m - height_m;
      if (std::abs(rise_m) <= max_step_m) return true;
    }
    return false;
  };
  for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}}) {
    float before_m = 0.0F;
    float after_m = 0.0F;
    if (findRise({column.x - dx, column.y - dy}, before_m) &&
        findRise({column.x + dx, column.y + dy}, after_m) &&
        std::abs(after_m - before_m) > 1.25F * max_step_m)
      return true;
  }
  return false;
}

/// @returns whether the patches differ from before
bool FloorMap::makePatches(const TileIndex& index) {
  Tile& tile = tiles_.at(index);
  const TilesAround<Tile> around(tiles_, index);
  std::vector<std::pair<int, bool>> before;
  for (GroundNode& node : tile.nodes) {
    before.emplace_back(node.patch, node.is_drop);
    const Column column = computeColumn(index, node.offset);
    const bool is_ground = node.is_walked || (!isCliffEdge(around, column, node.height_m, 1.0) &&
                                              !isSteep(around, column, node.height_m));
    node.patch = is_ground ? -2 : -1;
    node.is_drop = !is_ground && isCliffEdge(around, column, node.height_m, kDropSteps);
  }
  const std::vector<Patch> old = std::move(tile.patches);
  tile.patches.clear();
  for (std::size_t n = 0; n < tile.nodes.size(); ++n) {
    if (tile.nodes[n].patch == -2) spreadPatch(tile, n);
  }
  bool is_same = old.size() == tile.patches.size();
  for (std::size_t n = 0; n < tile.nodes.size(); ++n) {
    const GroundNode& node = tile.nodes[n];
    is_same = is_same && before[n] == std::pair(node.patch, node.is_drop);
  }
  if (is_same) {
    for (std::size_t p = 0; p < old.size(); ++p) {
      tile.patches[p].is_sure = old[p].is_sure;
      tile.patches[p].is_floor = old[p].is_floor;
    }
  }
  return !is_same;
}

void FloorMap::spreadPatch(Tile& tile, std::size_t seed) const {
  const auto id = static_cast<int>(tile.patches.size());
  const auto max_step_m = static_cast<float>(config_.max_step_m);
  Patch patch;
  std::vector<std::size_t> reached{seed};
  tile.nodes[seed].patch = id;
  for (std::size_t i = 0; i < reached.size(); ++i) {
    const GroundNode node = tile.nodes[reached[i]];
    ++patch.num_nodes;
    patch.is_walked = patch.is_walked || node.is_walked;
    const int x = node.offset % kTileSide;
    const int y = node.offset / kTileSide;
    for (const auto& [nx, ny] : {std::pair{x - 1, y}, {x + 1, y}, {x, y - 1}, {x, y + 1}}) {
      if (nx < 0 || ny < 0 || nx >= kTileSide || ny >= kTileSide) continue;
      const auto offset = static_cast<std::size_t>(nx + kTileSide * ny);
      for (int n = tile.begin[offset]; n < tile.begin[offset + 1]; ++n) {
        GroundNode& next = tile.nodes[static_cast<std::size_t>(n)];
        if (next.patch != -2 || std::abs(next.height_m - node.height_m) > max_step_m) continue;
        next.patch = id;
        reached.push_back(static_cast<std::size_t>(n));
      }
    }
  }
  tile.patches.push_back(patch);
}

template <typename Visit>
void FloorMap::forEachReached(const Column& column, float height_m, Visit visit) const {
  const TileIndex index = computeTile(column);
  const auto found = tiles_.find(index);
  if (found == tiles_.end()) return;
  const auto max_step_m = static_cast<float>(config_.max_step_m);
  const auto offset = static_cast<std::size_t>(computeOffset(column));
  for (int n = found->second.begin[offset]; n < found->second.begin[offset + 1]; ++n) {
    const GroundNode& node = found->second.nodes[static_cast<std::size_t>(n)];
    if (node.patch < 0 || std::abs(node.height_m - height_m) > max_step_m) continue;
    visit(PatchRef{index, node.patch});
  }
}

/// True if floor lies beside it, a step away at most.
bool FloorMap::isBesideFloor(const Column& column, float height_m) const {
  bool is_beside = false;
  for (int i = 0; i < 9; ++i) {
    forEachReached({column.x + i % 3 - 1, column.y + i / 3 - 1}, height_m,
                   [&](const PatchRef& ref) { is_beside = is_beside || patchAt(ref).is_floor; });
  }
  return is_beside;
}

/// Patches of the tiles beside that hang together with this one.
template <typename Visit>
void FloorMap::forEachNeighbour(const PatchRef& patch, Visit visit) const {
  for (const GroundNode& node : tiles_.at(patch.tile).nodes) {
    if (node.patch != patch.patch) continue;
    const int x = node.offset % kTileSide;
    const int y = node.offset / kTileSide;
    const Column at = computeColumn(patch.tile, node.offset);
    if (x == 0) forEachReached({at.x - 1, at.y}, node.height_m, visit);
    if (x == kTileSide - 1) forEachReached({at.x + 1, at.y}, node.height_m, visit);
    if (y == 0) forEachReached({at.x, at.y - 1}, node.height_m, visit);
    if (y == kTileSide - 1) forEachReached({at.x, at.y + 1}, node.height_m, visit);
  }
}

/// Whether the floor that a patch belongs to is sure. Looks no farther than needed; what it saw
/// goes to `seen`: all of a floor that is not.
bool FloorMap::computeIsSure(const PatchRef& seed, const std::map<PatchRef, bool>& decided,
                             std::vector<PatchRef>& seen) const {
  const double min_nodes =
      kSurelyFloor * config_.min_floor_area_m2 / (voxel_size_m_ * voxel_size_m_);
  std::set<PatchRef> is_seen{seed};
  seen.assign(1, seed);
  double num_nodes = 0.0;
  bool is_sure = false;
  for (std::size_t i = 0; i < seen.size() && !is_sure; ++i) {
    const PatchRef ref = seen[i];  // a copy: the list grows while its neighbours are looked at
    const Patch& patch = patchAt(ref);
    num_nodes += patch.num_nodes;
    is_sure = patch.is_walked || num_nodes >= min_nodes;
    forEachNeighbour(ref, [&](const PatchRef& next) {
      const auto known = decided.find(next);
      if (known != decided.end()) is_sure = is_sure || known->second;
      if (is_seen.insert(next).second) seen.push_back(next);
    });
  }
  return is_sure;
}

/// Of a sure floor: tells the patches that did not count as such.
void FloorMap::spreadSure(std::vector<PatchRef> patches, std::map<PatchRef, bool>& decided,
                          TileSet& changed) {
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const PatchRef ref = patches[i];
    Patch& patch = patchAt(ref);
    if (!patch.is_sure) changed.insert(ref.tile);
    patch.is_sure = true;
    decided[ref] = true;
    forEachNeighbour(ref, [&](const PatchRef& next) {
      if (patchAt(next).is_sure || !decided.emplace(next, true).second) return;
      patches.push_back(next);
    });
  }
}

/// @returns the tiles with a patch that became part of a sure floor, or no longer is
TileSet FloorMap::updateSure(const TileSet& with_patches) {
  TileSet changed;
  std::map<PatchRef, bool> decided;
  for (const TileIndex& index : widen(with_patches, 1)) {
    const auto tile = tiles_.find(index);
    if (tile == tiles_.end()) continue;
    for (int p = 0; p < static_cast<int>(tile->second.patches.size()); ++p) {
      if (decided.count({index, p}) > 0) continue;
      std::vector<PatchRef> seen;
      if (computeIsSure({index, p}, decided, seen)) {
        spreadSure(seen, decided, changed);
        continue;
      }
      for (const PatchRef& ref : seen) {
        decided[ref] = false;
        if (patchAt(ref).is_sure) changed.insert(ref.tile);
        patchAt(ref).is_sure = false;
      }
    }
  }
  return changed;
}

/// @returns the tiles with a patch that became floor, or no longer is
TileSet FloorMap::updateFloor(const TileSet& with_sure) {
  const int rings = (1 + computeGap() + kTileSide - 1) / kTileSide;
  TileSet changed;
  std::set<PatchRef> is_done;
  for (const TileIndex& index : widen(with_sure, rings)) {
    const auto tile = tiles_.find(index);
    if (tile == tiles_.end()) continue;
    for (int p = 0; p < static_cast<int>(tile->second.patches.size()); ++p) {
      if (is_done.count({index, p}) > 0) continue;
      const bool is_sure = tile->second.patches[static_cast<std::size_t>(p)].is_sure;
      const auto component =
          is_sure ? std::vector<PatchRef>{{index, p}} : collectComponent({index, p});
      const bool is_floor = is_sure || computeIsFloor(component);
      for (const PatchRef& ref : component) {
        is_done.insert(ref);
        if (patchAt(ref).is_floor != is_floor) changed.insert(ref.tile);
        patchAt(ref).is_floor = is_floor;
      }
    }
  }
  return changed;
}

/// All patches that hang together with one of a floor that is not sure.
std::vector<FloorMap::PatchRef> FloorMap::collectComponent(const PatchRef& seed) const {
  std::vector<PatchRef> component{seed};
  std::set<PatchRef> is_seen{seed};
  for (std::size_t i = 0; i < component.size(); ++i) {
    const PatchRef ref = component[i];  // a copy, as above
    forEachNeighbour(ref, [&](const PatchRef& next) {
      if (is_seen.insert(next).second) component.push_back(next);
    });
  }
  return component;
}

bool FloorMap::computeIsFloor(const std::vector<PatchRef>& component) const {
  const double min_nodes = config_.min_floor_area_m2 / (voxel_size_m_ * voxel_size_m_);
  int num_nodes = 0;
  int num_over_floor = 0;
  bool is_beside = false;
  for (const PatchRef& ref : component) {
    for (const GroundNode& node : tiles_.at(ref.tile).nodes) {
      if (node.patch != ref.patch) continue;
      const Beside beside =
          lookBeside(computeColumn(ref.tile, node.offset), node.height_m, 1 + computeGap());
      is_beside = is_beside || beside.is_floor;
      ++num_nodes;
      num_over_floor += beside.is_lower ? 1 : 0;
    }
  }
  return (is_beside || num_nodes >= min_nodes) && num_over_floor <= 0.5 * std::sqrt(num_nodes);
}

FloorMap::Beside FloorMap::lookBeside(const Column& column, float height_m, int reach) const {
  Beside beside;
  TileIndex last = computeTile(column);
  auto tile = tiles_.find(last);
  for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
    bool is_level = false;
    for (int length = 1; length <= reach && !is_level; ++length) {
      const Column at{column.x + length * dx, column.y + length * dy};
      if (computeTile(at) != last) {
        last = computeTile(at);
        tile = tiles_.find(last);
      }
      if (tile != tiles_.end()) lookAt(tile->second, at, height_m, beside, is_level);
    }
  }
  return beside;
}

/// @param is_level  set if there is ground a step away
void FloorMap::lookAt(const Tile& tile, const Column& column, float height_m, Beside& beside,
                      bool& is_level) const {
  const auto offset = static_cast<std::size_t>(computeOffset(column));
  for (int n = tile.begin[offset]; n < tile.begin[offset + 1]; ++n) {
    const GroundNode& node = tile.nodes[static_cast<std::size_t>(n)];
    if (node.patch < 0) continue;
    const bool is_sure = tile.patches[static_cast<std::size_t>(node.patch)].is_sure;
    const auto rise_m = static_cast<double>(node.height_m - height_m);
    if (std::abs(rise_m) <= config_.max_step_m) {
      is_level = true;
      beside.is_floor = beside.is_floor || is_sure;
    } else if (rise_m < 0.0) {
      beside.is_lower = beside.is_lower || is_sure;
    }
  }
}

int FloorMap::computeGap() const {
  return static_cast<int>(std::floor(2.0 * config_.max_floor_gap_m / voxel_size_m_));
}

}  // namespace tsg::places
