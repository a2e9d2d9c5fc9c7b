// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/mesh_markers.h"

namespace tsg::ros_interface {
namespace {

void appendTriangles(const Mesh& mesh, visualization_msgs::Marker& marker) {
  for (const auto& triangle : mesh.triangles) {
    for (const auto index : triangle) {
      const Eigen::Vector3f& vertex = mesh.vertices[index];
      geometry_msgs::Point point;
      point.x = vertex.x();
      point.y = vertex.y();
      point.z = vertex.z();
      marker.points.push_back(point);
      std_msgs::ColorRGBA color;
      color.r = static_cast<float>(mesh.colors[index][0]) / 255.0F;
      color.g = static_cast<float>(mesh.colors[index][1]) / 255.0F;
      color.b = static_cast<float>(mesh.colors[index][2]) / 255.0F;
      color.a = 1.0F;
      marker.colors.push_back(color);
    }
  }
}

}  // namespace

mapping::GridIndex computeMeshChunk(const mapping::GridIndex& block) {
  static_assert(kMeshChunkSide == 4);
  return {block.x() >> 2, block.y() >> 2, block.z() >> 2};
}

MeshMarkers::Chunk& MeshMarkers::findChunk(const mapping::GridIndex& block) {
  const auto next_id = static_cast<int>(chunks_.size());
  const auto [entry, is_new] = chunks_.try_emplace(computeMeshChunk(block));
  if (is_new) entry->second.marker_id = next_id;
  return entry->second;
}

void MeshMarkers::note(const mapping::MeshUpdate& update) {
  for (const auto& block : update.changed) findChunk(block.block).blocks.insert(block.block);
  for (const auto& block : update.removed) findChunk(block).blocks.erase(block);
}

std::vector<visualization_msgs::MarkerArray> MeshMarkers::update(const mapping::MeshUpdate& update,
                                                                 const FindMesh& find_mesh) {
  note(update);
  std::map<int, const Chunk*> changed;
  const auto collect = [&](const mapping::GridIndex& block) {
    const Chunk& chunk = findChunk(block);
    changed[chunk.marker_id] = &chunk;
  };
  for (const auto& block : update.changed) collect(block.block);
  for (const auto& block : update.removed) collect(block);
  return pack(changed, find_mesh);
}

std::vector<visualization_msgs::MarkerArray> MeshMarkers::all(const FindMesh& find_mesh) const {
  std::map<int, const Chunk*> chunks;
  for (const auto& [index, chunk] : chunks_) {
    if (!chunk.blocks.empty()) chunks[chunk.marker_id] = &chunk;
  }
  return pack(chunks, find_mesh);
}

visualization_msgs::Marker MeshMarkers::makeMarker(const Chunk& chunk,
                                                   const FindMesh& find_mesh) const {
  visualization_msgs::Marker marker;
  marker.header.frame_id = world_frame_;  // stamp 0: rviz takes the newest transform
  marker.ns = "mesh";
  marker.id = chunk.marker_id;
  marker.type = visualization_msgs::Marker::TRIANGLE_LIST;
  marker.action = visualization_msgs::Marker::ADD;
  marker.pose.orientation.w = 1.0;
  marker.scale.x = marker.scale.y = marker.scale.z = 1.0;
  marker.color.a = 1.0F;
  for (const auto& block : chunk.blocks) appendTriangles(*find_mesh(block), marker);
  if (marker.points.empty()) marker.action = visualization_msgs::Marker::DELETE;
  return marker;
}

std::vector<visualization_msgs::MarkerArray> MeshMarkers::pack(
    const std::map<int, const Chunk*>& chunks, const FindMesh& find_mesh) const {
  std::vector<visualization_msgs::MarkerArray> messages;
  std::size_t num_vertices = 0;
  for (const auto& [id, chunk] : chunks) {
    visualization_msgs::Marker marker = makeMarker(*chunk, find_mesh);
    num_vertices += marker.points.size();
    if (messages.empty() || num_vertices > kMaxVertices) {
      messages.emplace_back();
      num_vertices = marker.points.size();
    }
    messages.back().markers.push_back(std::move(marker));
  }
  return messages;
}

}  // namespace tsg::ros_interface
