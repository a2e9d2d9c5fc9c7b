// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/places/ground_map.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace tsg::places {
namespace {

using Nodes = std::vector<GroundNode>;

/// Box of columns and, per column, its nodes as a range of `nodes`.
struct NodeGrid {
  GridExtent extent;
  std::vector<std::size_t> begin;  ///< one more than there are columns
  Nodes nodes;                     ///< by column, then by height
};

GridExtent computeExtent(const Nodes& nodes) {
  GridIndex min(nodes[0].x, nodes[0].y, 0);
  GridIndex max = min;
  for (const GroundNode& node : nodes) {
    min = min.cwiseMin(GridIndex(node.x, node.y, 0));
    max = max.cwiseMax(GridIndex(node.x, node.y, 0));
  }
  return {min, max - min + GridIndex::Ones()};
}

/// Counting sort by column; nodes of a column keep their order.
NodeGrid makeNodeGrid(const Nodes& nodes, double voxel_size_m) {
  NodeGrid grid;
  grid.extent = computeExtent(nodes);
  requireBounded(grid.extent, voxel_size_m);
  grid.begin.assign(grid.extent.numCells() + 1, 0);
  std::vector<std::size_t> columns;
  columns.reserve(nodes.size());
  for (const GroundNode& node : nodes) {
    columns.push_back(grid.extent.toLinear({node.x, node.y, 0}));
    ++grid.begin[columns.back() + 1];
  }
  for (std::size_t i = 1; i < grid.begin.size(); ++i) grid.begin[i] += grid.begin[i - 1];
  std::vector<std::size_t> next(grid.begin.begin(), grid.begin.end() - 1);
  grid.nodes.resize(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) grid.nodes[next[columns[i]]++] = nodes[i];
  return grid;
}

/// True if a column beside the node has ground below and none that a step would reach.
bool isCliffEdge(const NodeGrid& grid, const GroundNode& node, double max_step_m) {
  for (int i = 0; i < 9; ++i) {
    const GridIndex column(node.x + i % 3 - 1, node.y + i / 3 - 1, 0);
    if (!grid.extent.contains(column)) continue;
    const std::size_t linear = grid.extent.toLinear(column);
    bool has_lower = false;
    bool has_level = false;
    for (std::size_t n = grid.begin[linear]; n < grid.begin[linear + 1]; ++n) {
      const double rise_m = static_cast<double>(grid.nodes[n].height_m - node.height_m);
      has_level = has_level || std::abs(rise_m) <= max_step_m;
      has_lower = has_lower || rise_m < -max_step_m;
    }
    if (has_lower && !has_level) return true;
  }
  return false;
}

/// Noise at the edge of a cabinet can look like a ramp to its top; without the edge it does not.
Nodes removeCliffEdges(Nodes nodes, double voxel_size_m, double max_step_m) {
  const NodeGrid grid = makeNodeGrid(nodes, voxel_size_m);
  const auto is_edge = [&](const GroundNode& node) { return isCliffEdge(grid, node, max_step_m); };
  nodes.erase(std::remove_if(nodes.begin(), nodes.end(), is_edge), nodes.end());
  return nodes;
}

/// How far and how high from one column to another.
struct Step {
  int columns = 1;
  double max_height_m = 0.0;
};

/// Calls `visit(node)` for the nodes that a step along x or y can reach: those of the nearest
/// column in each direction that has any.
template <typename Visit>
void forEachStep(const NodeGrid& grid, const GroundNode& from, const Step& step, Visit visit) {
  for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
    bool has_found = false;
    for (int length = 1; length <= step.columns && !has_found; ++length) {
      const GridIndex column(from.x + length * dx, from.y + length * dy, 0);
      if (!grid.extent.contains(column)) break;
      const std::size_t linear = grid.extent.toLinear(column);
      for (std::size_t n = grid.begin[linear]; n < grid.begin[linear + 1]; ++n) {
        const double rise_m = static_cast<double>(grid.nodes[n].height_m - from.height_m);
        if (std::abs(rise_m) > step.max_height_m) continue;
        has_found = true;
        visit(n);
      }
    }
  }
}

/// Nodes (indices) reachable by steps from `seed`; they are marked as taken.
std::vector<std::size_t> collectReachable(const NodeGrid& grid, std::size_t seed, const Step& step,
                                          std::vector<char>& is_taken) {
  std::vector<std::size_t> reached{seed};
  is_taken[seed] = 1;
  for (std::size_t i = 0; i < reached.size(); ++i) {
    forEachStep(grid, grid.nodes[reached[i]], step, [&](std::size_t next) {
      if (is_taken[next] != 0) return;
      is_taken[next] = 1;
      reached.push_back(next);
    });
  }
  return reached;
}

/// Nodes of floors that are large without any gap.
std::vector<std::size_t> findSeeds(const NodeGrid& grid, double max_step_m, std::size_t min_nodes) {
  std::vector<char> is_taken(grid.nodes.size(), 0);
  std::vector<std::size_t> seeds;
  for (std::size_t node = 0; node < grid.nodes.size(); ++node) {
    if (is_taken[node] != 0) continue;
    const auto floor = collectReachable(grid, node, {1, max_step_m}, is_taken);
    if (floor.size() >= min_nodes) seeds.push_back(node);
  }
  return seeds;
}

/// Where a floor passes under itself (ramps), the lower storey counts.
Floor makeFloor(const Nodes& nodes) {
  Floor floor;
  floor.extent = computeExtent(nodes);
  floor.height_m.assign(floor.extent.numCells(), kNotObserved);
  for (const GroundNode& node : nodes) {
    float& height_m = floor.height_m[floor.extent.toLinear({node.x, node.y, 0})];
    if (isUnknown(height_m) || node.height_m < height_m) height_m = node.height_m;
  }
  return floor;
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

void GroundMap::updateColumns(const VoxelMap& voxels,
                              const std::vector<VoxelMap::ColumnIndex>& changed) {
  for (const VoxelMap::ColumnIndex& index : changed) {
    const auto columns = voxels.readColumns(index);
    auto& heights_m = heights_m_[index];
    for (std::size_t i = 0; i < columns.size(); ++i) {
      heights_m[i] = findGround(columns[i], voxels.voxelSize(), config_.body_height_m);
    }
  }
}

std::vector<Floor> GroundMap::computeFloors(double voxel_size_m) const {
  const auto gap = static_cast<int>(std::floor(2.0 * config_.max_floor_gap_m / voxel_size_m));
  std::vector<VoxelMap::ColumnIndex> columns;
  for (const auto& [index, heights_m] : heights_m_) columns.push_back(index);
  std::vector<Nodes> floors;
  for (const auto& island : splitIntoIslands(columns, 1 + gap / mapping::kBlockSide)) {
    addFloors(collectNodes(island), gap, voxel_size_m, floors);
  }
  std::stable_sort(floors.begin(), floors.end(),
                   [](const Nodes& a, const Nodes& b) { return a.size() > b.size(); });
  std::vector<Floor> result;
  for (const Nodes& floor : floors) result.push_back(makeFloor(floor));
  return result;
}

std::vector<GroundNode> GroundMap::collectNodes(
    const std::vector<VoxelMap::ColumnIndex>& columns) const {
  Nodes nodes;
  for (const auto& index : columns) {
    const auto& heights_m = heights_m_.at(index);
    for (int i = 0; i < 64; ++i) {
      for (const float height_m : heights_m[static_cast<std::size_t>(i)]) {
        nodes.push_back({index.first * 8 + i % 8, index.second * 8 + i / 8, height_m});
      }
    }
  }
  return nodes;
}

void GroundMap::addFloors(std::vector<GroundNode> nodes, int gap, double voxel_size_m,
                          std::vector<std::vector<GroundNode>>& floors) const {
  if (!nodes.empty()) nodes = removeCliffEdges(std::move(nodes), voxel_size_m, config_.max_step_m);
  if (nodes.empty()) return;
  const NodeGrid grid = makeNodeGrid(nodes, voxel_size_m);
  const double min_nodes = config_.min_floor_area_m2 / (voxel_size_m * voxel_size_m);
  std::vector<char> is_taken(grid.nodes.size(), 0);
  for (const std::size_t seed :
       findSeeds(grid, config_.max_step_m, static_cast<std::size_t>(std::ceil(min_nodes)))) {
    if (is_taken[seed] != 0) continue;
    floors.emplace_back();
    for (const std::size_t node :
         collectReachable(grid, seed, {1 + gap, config_.max_step_m}, is_taken)) {
      floors.back().push_back(grid.nodes[node]);
    }
  }
}

}  // namespace tsg::places
