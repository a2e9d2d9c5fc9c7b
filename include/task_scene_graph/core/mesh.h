// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "task_scene_graph/core/box.h"

namespace tsg {

/// Indexed triangle mesh in the world frame.
struct Mesh {
  std::vector<Eigen::Vector3f> vertices;                ///< metres
  std::vector<std::array<std::uint8_t, 3>> colors;      ///< RGB, one per vertex
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise seen from free space

  bool isEmpty() const { return triangles.empty(); }

  /// Appends another mesh; its triangle indices are shifted by the vertices present before.
  void append(const Mesh& other);

  Aabb computeBounds() const;
};

}  // namespace tsg
