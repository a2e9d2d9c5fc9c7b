// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/mesh.h"

namespace tsg {

void Mesh::append(const Mesh& other) {
  const auto offset = static_cast<std::uint32_t>(vertices.size());
  vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
  colors.insert(colors.end(), other.colors.begin(), other.colors.end());
  for (const auto& t : other.triangles) {
    triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  }
}

Aabb Mesh::computeBounds() const {
  Aabb bounds;
  for (const auto& vertex : vertices) bounds.extend(vertex.cast<double>());
  return bounds;
}

}  // namespace tsg
