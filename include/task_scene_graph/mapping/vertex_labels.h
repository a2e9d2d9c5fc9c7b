// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "task_scene_graph/core/primitives.h"

namespace tsg::mapping {

/// Which object the surface of a mesh belongs to.
struct LabelledMesh {
  const Mesh* mesh = nullptr;
  std::int32_t label = 0;
};

/// For each vertex of `mesh` the label of the object whose surface is nearest, if it is within
/// `max_distance_m`; else 0. Of equally near ones, the least label. The order of the objects does
/// not matter. O(vertices + triangles of the objects * vertices near each).
/// @throws std::invalid_argument unless max_distance_m is positive.
std::vector<std::int32_t> labelVertices(const Mesh& mesh, const std::vector<LabelledMesh>& objects,
                                        double max_distance_m);

/// The same with the meshes of primitives, each under the label it has in `label_of_primitive`;
/// primitives that have none are left out.
std::vector<std::int32_t> labelVertices(
    const Mesh& mesh, const std::vector<ObjectPrimitivePtr>& primitives,
    const std::map<PrimitiveId, std::int32_t>& label_of_primitive, double max_distance_m);

}  // namespace tsg::mapping
