// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/mapping/background_map.h"

/// Parts of a map in other coordinates.
namespace tsg::map {

void moveMesh(const Pose& T, Mesh& mesh);

/// Its mesh and boxes; the same to the bit for the identity. The axis-aligned box of one without a
/// mesh is the hull of its turned box, the upright one keeps its height.
ObjectPrimitive movePrimitive(const ObjectPrimitive& primitive, const Pose& T);

struct IsBlockBefore {
  bool operator()(const mapping::GridIndex& a, const mapping::GridIndex& b) const {
    return mapping::isBefore(a, b);
  }
};

/// The cell of a grid with sides of `side_m` in which the middle of a triangle lies.
mapping::GridIndex findCell(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle,
                            double side_m);

/// Gathers triangles by the block in which their middle lies.
class BlockGatherer {
 public:
  using Meshes = std::map<mapping::GridIndex, Mesh, IsBlockBefore>;

  explicit BlockGatherer(double block_side_m) : block_side_m_(block_side_m) {}

  /// The next triangles are of another mesh: their vertices are other ones.
  void startMesh();
  void add(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle);
  Meshes take();

 private:
  struct Block {
    Mesh mesh;
    std::vector<std::uint32_t> vertices;  ///< here, of those of the mesh at hand; empty: none yet
  };

  Block& blockOf(const mapping::GridIndex& index);

  double block_side_m_;
  std::map<mapping::GridIndex, Block, IsBlockBefore> blocks_;
  std::vector<Block*> used_;  ///< by the mesh at hand
  mapping::GridIndex last_index_ = mapping::GridIndex::Zero();
  Block* last_block_ = nullptr;  ///< of that index
};

/// Puts more triangles into the meshes of blocks, ascending by (z, y, x).
void addToBlocks(BlockGatherer::Meshes meshes, std::vector<mapping::BlockMesh>& blocks);

}  // namespace tsg::map
