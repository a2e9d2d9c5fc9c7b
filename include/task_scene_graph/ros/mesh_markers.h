// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <map>
#include <string>
#include <unordered_map>
#include <vector>

#include "task_scene_graph/mapping/background_map.h"

namespace tsg::ros_interface {

/// The background mesh as markers for rviz: one TRIANGLE_LIST per cube of kChunkSide^3 blocks,
/// under an id that never changes; only chunks that changed are sent again, in messages of bounded
/// size.
class MeshMarkers {
 public:
  static constexpr int kChunkSide = 4;
  static constexpr std::size_t kMaxVertices = 150000;  ///< of one message, 40 bytes each

  explicit MeshMarkers(std::string world_frame) : world_frame_(std::move(world_frame)) {}

  /// Takes in an update; returns the chunks that changed (DELETE for those that are empty now).
  std::vector<visualization_msgs::MarkerArray> update(const mapping::MeshUpdate& update);
  /// Every chunk there is, for a subscriber that comes late.
  std::vector<visualization_msgs::MarkerArray> all() const;
  std::size_t numChunks() const { return chunks_.size(); }

 private:
  struct BlockOrder {
    bool operator()(const mapping::GridIndex& a, const mapping::GridIndex& b) const;
  };
  struct Chunk {
    int marker_id = 0;
    std::map<mapping::GridIndex, std::shared_ptr<const Mesh>, BlockOrder> blocks;
  };
  using Chunks = std::map<mapping::GridIndex, Chunk, BlockOrder>;

  Chunk& findChunk(const mapping::GridIndex& block, std::map<int, const Chunk*>& changed);
  visualization_msgs::Marker makeMarker(const Chunk& chunk) const;
  std::vector<visualization_msgs::MarkerArray> pack(
      const std::map<int, const Chunk*>& chunks) const;

  std::string world_frame_;
  Chunks chunks_;
};

}  // namespace tsg::ros_interface
