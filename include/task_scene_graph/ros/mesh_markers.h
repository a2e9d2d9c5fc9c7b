// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "task_scene_graph/mapping/background_map.h"

namespace tsg::ros_interface {

/// Ascending by (z, y, x), for ordered containers.
struct BlockOrder {
  bool operator()(const mapping::GridIndex& a, const mapping::GridIndex& b) const {
    return mapping::isBefore(a, b);
  }
};

/// Blocks are drawn in cubes of kMeshChunkSide^3: a block alone is too little for one draw call.
constexpr int kMeshChunkSide = 4;
mapping::GridIndex computeMeshChunk(const mapping::GridIndex& block);

/// Gives the mesh of a block that has one.
using FindMesh = std::function<std::shared_ptr<const Mesh>(const mapping::GridIndex& block)>;

/// The background mesh as markers for rviz: one TRIANGLE_LIST per chunk, under an id that never
/// changes; only chunks that changed are sent again, in messages of bounded size. Keeps indices
/// only: meshes are asked for.
class MeshMarkers {
 public:
  static constexpr std::size_t kMaxVertices = 150000;  ///< of one message, 40 bytes each

  explicit MeshMarkers(std::string world_frame) : world_frame_(std::move(world_frame)) {}

  /// Takes in an update that nobody is told of.
  void note(const mapping::MeshUpdate& update);
  /// Takes in an update; returns the chunks that changed (DELETE for those that are empty now).
  std::vector<visualization_msgs::MarkerArray> update(const mapping::MeshUpdate& update,
                                                      const FindMesh& find_mesh);
  /// Every chunk there is, for a subscriber that comes late.
  std::vector<visualization_msgs::MarkerArray> all(const FindMesh& find_mesh) const;
  std::size_t numChunks() const { return chunks_.size(); }

 private:
  struct Chunk {
    int marker_id = 0;
    std::set<mapping::GridIndex, BlockOrder> blocks;
  };

  Chunk& findChunk(const mapping::GridIndex& block);
  visualization_msgs::Marker makeMarker(const Chunk& chunk, const FindMesh& find_mesh) const;
  std::vector<visualization_msgs::MarkerArray> pack(const std::map<int, const Chunk*>& chunks,
                                                    const FindMesh& find_mesh) const;

  std::string world_frame_;
  std::map<mapping::GridIndex, Chunk, BlockOrder> chunks_;
};

}  // namespace tsg::ros_interface
