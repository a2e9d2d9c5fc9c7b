// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "task_scene_graph/core/mesh.h"

namespace tsg::mapping {

/// A mesh that is put away: compressed without loss to about a third of its size. Immutable.
class PackedMesh {
 public:
  /// @throws std::runtime_error if memory runs out.
  explicit PackedMesh(const Mesh& mesh);

  /// The mesh, bit by bit. O(size).
  Mesh unpack() const;

  std::size_t bytes() const { return bytes_.size(); }

 private:
  std::size_t vertices_;
  std::size_t triangles_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace tsg::mapping
