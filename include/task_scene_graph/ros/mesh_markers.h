// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <map>
#include <string>
#include <vector>

#include "task_scene_graph/mapping/mesh_table.h"
#include "task_scene_graph/mapping/tsdf_integrator.h"

namespace tsg::ros_interface {

/// Ascending by (z, y, x), for ordered containers.
struct BlockOrder {
  bool operator()(const mapping::GridIndex& a, const mapping::GridIndex& b) const {
    return mapping::isBefore(a, b);
  }
};

/// The background mesh as markers for rviz: one TRIANGLE_LIST per chunk (a block alone is too
/// little for one draw call), under an id that never changes, in messages of bounded size. Keeps
/// ids only.
class MeshMarkers {
 public:
  static constexpr std::size_t kMaxVertices = 25000;  ///< of one message, 40 bytes each

  explicit MeshMarkers(std::string world_frame) : world_frame_(std::move(world_frame)) {}

  /// Markers of chunks[next] and those after it, as many as one message takes (one at least), as
  /// they are in `meshes`; DELETE for those without a mesh that had one. Moves `next` on.
  /// @throws std::runtime_error as StoredMesh::load().
  visualization_msgs::MarkerArray makePart(const std::vector<mapping::GridIndex>& chunks,
                                           std::size_t& next, const mapping::MeshTable& meshes);

  /// A message that deletes all markers; ids begin anew.
  visualization_msgs::MarkerArray clear();

 private:
  visualization_msgs::Marker makeMarker(int id, const mapping::MeshTable::Chunk* chunk) const;

  std::string world_frame_;
  std::map<mapping::GridIndex, int, BlockOrder> ids_;
};

}  // namespace tsg::ros_interface
