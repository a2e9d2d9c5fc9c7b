// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/map/moving.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

namespace tsg::map {
namespace {

constexpr std::uint32_t kNotHere = std::numeric_limits<std::uint32_t>::max();

/// The hull of a box that was turned.
Aabb moveBox(const Aabb& box, const Pose& T) {
  Aabb moved;
  for (int corner = 0; corner < 8; ++corner) {
    moved.extend(T * box.corner(static_cast<Aabb::CornerType>(corner)));
  }
  return moved;
}

OrientedBox moveBox(const OrientedBox& box, const Pose& T) {
  std::vector<Eigen::Vector3f> corners;
  for (const Eigen::Vector3f& corner : box.corners()) {
    corners.emplace_back((T * corner.cast<double>()).cast<float>());
  }
  OrientedBox moved = computeOrientedBox(corners);
  moved.size_m.z() = box.size_m.z();
  return moved;
}

}  // namespace

void moveMesh(const Pose& T, Mesh& mesh) {
  const Eigen::Isometry3f T_float = T.cast<float>();
  for (auto& vertex : mesh.vertices) vertex = T_float * vertex;
}

ObjectPrimitive movePrimitive(const ObjectPrimitive& primitive, const Pose& T) {
  ObjectPrimitive moved = primitive;
  if (T.isApprox(Pose::Identity(), 0.0)) return moved;
  moveMesh(T, moved.mesh);
  moved.box = moved.mesh.vertices.empty() ? moveBox(primitive.box, T) : moved.mesh.computeBounds();
  if (!primitive.oriented_box.isEmpty()) moved.oriented_box = moveBox(primitive.oriented_box, T);
  return moved;
}

mapping::GridIndex findCell(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle,
                            double side_m) {
  const Eigen::Vector3f middle_m =
      (mesh.vertices[triangle[0]] + mesh.vertices[triangle[1]] + mesh.vertices[triangle[2]]) / 3.0F;
  return (middle_m.cast<double>() / side_m).array().floor().cast<int>();
}

void BlockGatherer::startMesh() {
  for (Block* block : used_) block->vertices.clear();
  used_.clear();
}

BlockGatherer::Block& BlockGatherer::blockOf(const mapping::GridIndex& index) {
  if (last_block_ == nullptr || index != last_index_) {
    last_block_ = &blocks_[index];
    last_index_ = index;
  }
  return *last_block_;
}

void BlockGatherer::add(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
  Block& block = blockOf(findCell(mesh, triangle, block_side_m_));
  if (block.vertices.empty()) {
    used_.push_back(&block);
    block.vertices.assign(mesh.vertices.size(), kNotHere);
  }
  std::array<std::uint32_t, 3> moved{};
  for (std::size_t i = 0; i < 3; ++i) {
    std::uint32_t& here = block.vertices[triangle[i]];
    if (here == kNotHere) {
      here = static_cast<std::uint32_t>(block.mesh.vertices.size());
      block.mesh.vertices.push_back(mesh.vertices[triangle[i]]);
      block.mesh.colors.push_back(mesh.colors[triangle[i]]);
    }
    moved[i] = here;
  }
  block.mesh.triangles.push_back(moved);
}

BlockGatherer::Meshes BlockGatherer::take() {
  Meshes meshes;
  for (auto& [index, block] : blocks_) meshes[index] = std::move(block.mesh);
  return meshes;
}

void addToBlocks(BlockGatherer::Meshes meshes, std::vector<mapping::BlockMesh>& blocks) {
  for (auto& block : blocks) {
    const auto found = meshes.find(block.block);
    if (found == meshes.end()) continue;
    Mesh both = *block.mesh;
    both.append(found->second);
    block.mesh = std::make_shared<const Mesh>(std::move(both));
    meshes.erase(found);
  }
  for (auto& [index, mesh] : meshes) {
    blocks.push_back({index, std::make_shared<const Mesh>(std::move(mesh))});
  }
  std::sort(blocks.begin(), blocks.end(),
            [](const auto& x, const auto& y) { return mapping::isBefore(x.block, y.block); });
}

}  // namespace tsg::map
