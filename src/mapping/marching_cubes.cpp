// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/marching_cubes.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <unordered_map>

#include "task_scene_graph/core/parallel.h"
#include "task_scene_graph/mapping/marching_cubes_table.h"

namespace tsg::mapping {
namespace {

constexpr int kSide = kBlockSide + 1;  // corners of a block's cells
constexpr int kCorners = kSide * kSide * kSide;
constexpr int kSliceVoxels = kBlockSide * kBlockSide;
constexpr std::uint32_t kNoVertex = std::numeric_limits<std::uint32_t>::max();

int cornerIndex(int x, int y, int z) { return x + kSide * (y + kSide * z); }

/// From the lowest corner of a cell to its corner i.
constexpr std::array<int, 8> kCornerSteps{0,
                                          1,
                                          kSide,
                                          kSide + 1,
                                          kSide* kSide,
                                          kSide* kSide + 1,
                                          kSide* kSide + kSide,
                                          kSide* kSide + kSide + 1};

std::size_t toSize(int value) { return static_cast<std::size_t>(value); }

/// The voxels at the corners of a block's cells, copied from the block and its upper neighbours.
struct Corners {
  std::array<float, kCorners> distance_m{};
  std::array<std::uint8_t, kCorners> is_known{};
  std::array<VoxelColor, kCorners> colors{};
  bool has_inside = false;
  bool has_outside = false;

  /// Bit i is set where corner i of the cell is inside; -1 if a corner is not known.
  int computeCubeIndex(const GridIndex& cell) const {
    const int origin = cornerIndex(cell.x(), cell.y(), cell.z());
    unsigned inside = 0;
    for (std::size_t i = 0; i < 8; ++i) {
      const auto corner = toSize(origin + kCornerSteps[i]);
      if (is_known[corner] == 0) return -1;
      if (distance_m[corner] < 0.0F) inside |= 1U << i;
    }
    return static_cast<int>(inside);
  }
};

void copyNeighbor(const TsdfBlock& from, const GridIndex& step, double min_weight, Corners& to) {
  const auto count = [&](int axis) { return step[axis] == 0 ? kBlockSide : 1; };
  for (int z = 0; z < count(2); ++z) {
    for (int y = 0; y < count(1); ++y) {
      for (int x = 0; x < count(0); ++x) {
        const auto voxel = toSize(TsdfBlock::computeLinearIndex({x, y, z}));
        if (!(from.voxels[voxel].weight > min_weight)) continue;
        const auto corner = toSize(cornerIndex(x + step.x() * kBlockSide, y + step.y() * kBlockSide,
                                               z + step.z() * kBlockSide));
        to.is_known[corner] = 1;
        to.distance_m[corner] = from.voxels[voxel].distance_m;
        to.colors[corner] = from.colors[voxel];
        (to.distance_m[corner] < 0.0F ? to.has_inside : to.has_outside) = true;
      }
    }
  }
}

Corners copyCorners(const TsdfVolume& volume, const GridIndex& block, double min_weight) {
  Corners corners;
  for (int i = 0; i < 8; ++i) {
    const GridIndex step(i & 1, i >> 1 & 1, i >> 2 & 1);
    if (const TsdfBlock* from = volume.findBlock(block + step)) {
      copyNeighbor(*from, step, min_weight, corners);
    }
  }
  return corners;
}

std::array<std::uint8_t, 3> mixColors(const VoxelColor& a, const VoxelColor& b, float share_b) {
  if (b.known == 0) share_b = 0.0F;
  if (a.known == 0) share_b = 1.0F;
  const auto mix = [share_b](std::uint8_t from, std::uint8_t to) {
    return static_cast<std::uint8_t>(static_cast<float>(from) +
                                     (static_cast<float>(to) - static_cast<float>(from)) * share_b +
                                     0.5F);
  };
  return {mix(a.r, b.r), mix(a.g, b.g), mix(a.b, b.b)};
}

/// Vertices of a block's mesh by the edge that they lie on; each is made once.
class EdgeVertices {
 public:
  EdgeVertices(const Corners& corners, const GridIndex& block, double voxel_size_m, Mesh& mesh)
      : corners_(corners),
        first_voxel_(block * kBlockSide),
        voxel_size_m_(voxel_size_m),
        mesh_(mesh) {
    vertex_of_edge_.fill(kNoVertex);
  }

  /// Index of the vertex on an edge of the cell.
  std::uint32_t find(const GridIndex& cell, std::uint8_t edge_index) {
    const CellEdge& edge = cellEdges()[edge_index];
    const GridIndex from = cell + GridIndex(edge.from & 1, edge.from >> 1 & 1, edge.from >> 2 & 1);
    const int corner = cornerIndex(from.x(), from.y(), from.z());
    std::uint32_t& vertex = vertex_of_edge_[toSize(3 * corner + edge.axis)];
    if (vertex != kNoVertex) return vertex;
    const int other = corner + kCornerSteps[std::size_t{1} << edge.axis];
    const double a = corners_.distance_m[toSize(corner)];
    const double b = corners_.distance_m[toSize(other)];
    const double share = a / (a - b);  // [Lorensen and Cline 1987]: where the distance is 0
    Eigen::Vector3d position = (first_voxel_ + from).cast<double>().array() + 0.5;
    position[edge.axis] += share;
    mesh_.vertices.push_back((voxel_size_m_ * position).cast<float>());
    mesh_.colors.push_back(mixColors(corners_.colors[toSize(corner)],
                                     corners_.colors[toSize(other)], static_cast<float>(share)));
    return vertex = static_cast<std::uint32_t>(mesh_.vertices.size() - 1);
  }

 private:
  const Corners& corners_;
  GridIndex first_voxel_;
  double voxel_size_m_;
  Mesh& mesh_;
  std::array<std::uint32_t, 3 * kCorners> vertex_of_edge_;
};

struct PositionHash {
  std::size_t operator()(const Eigen::Vector3f& p) const {
    std::array<std::uint32_t, 3> bits{};
    std::memcpy(bits.data(), p.data(), sizeof(bits));
    return GridIndexHash()(
        GridIndex(static_cast<int>(bits[0]), static_cast<int>(bits[1]), static_cast<int>(bits[2])));
  }
};

}  // namespace

Mesh computeBlockMesh(const TsdfVolume& volume, const GridIndex& block, double min_weight) {
  if (volume.findBlock(block) == nullptr) return {};
  const Corners corners = copyCorners(volume, block, min_weight);
  if (!corners.has_inside || !corners.has_outside) return {};
  Mesh mesh;
  EdgeVertices vertices(corners, block, volume.voxelSize(), mesh);
  for (int i = 0; i < kBlockVoxels; ++i) {
    const GridIndex cell(i % kBlockSide, i / kBlockSide % kBlockSide, i / kSliceVoxels);
    const int cube_index = corners.computeCubeIndex(cell);
    if (cube_index < 0) continue;
    for (const auto& t : cellTriangles()[toSize(cube_index)]) {  // [Lorensen and Cline 1987]
      mesh.triangles.push_back(
          {vertices.find(cell, t[0]), vertices.find(cell, t[1]), vertices.find(cell, t[2])});
    }
  }
  return mesh;
}

Mesh computeMesh(const TsdfVolume& volume, double min_weight, int num_threads) {
  const auto indices = volume.sortedBlockIndices();
  std::vector<Mesh> meshes(indices.size());
  parallelFor(indices.size(), num_threads,
              [&](std::size_t i) { meshes[i] = computeBlockMesh(volume, indices[i], min_weight); });
  Mesh all;
  for (const auto& mesh : meshes) all.append(mesh);
  return weldVertices(all);
}

Mesh weldVertices(const Mesh& mesh) {
  Mesh welded;
  std::unordered_map<Eigen::Vector3f, std::uint32_t, PositionHash> seen;
  seen.reserve(mesh.vertices.size());
  std::vector<std::uint32_t> welded_index;
  welded_index.reserve(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    // Adding zero makes -0 and 0 the same bits.
    const Eigen::Vector3f position = mesh.vertices[i].array() + 0.0F;
    const auto next = static_cast<std::uint32_t>(welded.vertices.size());
    const auto [entry, is_new] = seen.try_emplace(position, next);
    welded_index.push_back(entry->second);
    if (!is_new) continue;
    welded.vertices.push_back(position);
    welded.colors.push_back(mesh.colors[i]);
  }
  for (const auto& t : mesh.triangles) {
    const std::array<std::uint32_t, 3> triangle{welded_index[t[0]], welded_index[t[1]],
                                                welded_index[t[2]]};
    const bool is_flat =
        triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0];
    if (!is_flat) welded.triangles.push_back(triangle);
  }
  return welded;
}

}  // namespace tsg::mapping
