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

visualization_msgs::MarkerArray MeshMarkers::makePart(const std::vector<mapping::GridIndex>& chunks,
                                                      std::size_t& next,
                                                      const mapping::MeshTable& meshes) {
  visualization_msgs::MarkerArray message;
  std::size_t num_vertices = 0;
  for (; next < chunks.size(); ++next) {
    const auto* chunk = meshes.findChunk(chunks[next]);
    if (chunk == nullptr && ids_.count(chunks[next]) == 0) continue;
    const int id = ids_.try_emplace(chunks[next], static_cast<int>(ids_.size())).first->second;
    visualization_msgs::Marker marker = makeMarker(id, chunk);
    num_vertices += marker.points.size();
    if (num_vertices > kMaxVertices && !message.markers.empty()) return message;
    message.markers.push_back(std::move(marker));
  }
  return message;
}

visualization_msgs::MarkerArray MeshMarkers::clear() {
  ids_.clear();
  visualization_msgs::MarkerArray message;
  message.markers.emplace_back();
  message.markers[0].header.frame_id = world_frame_;
  message.markers[0].ns = "mesh";
  message.markers[0].action = visualization_msgs::Marker::DELETEALL;
  return message;
}

visualization_msgs::Marker MeshMarkers::makeMarker(int id,
                                                   const mapping::MeshTable::Chunk* chunk) const {
  visualization_msgs::Marker marker;
  marker.header.frame_id = world_frame_;  // stamp 0: rviz takes the newest transform
  marker.ns = "mesh";
  marker.id = id;
  marker.type = visualization_msgs::Marker::TRIANGLE_LIST;
  marker.action =
      chunk == nullptr ? visualization_msgs::Marker::DELETE : visualization_msgs::Marker::ADD;
  marker.pose.orientation.w = 1.0;
  marker.scale.x = marker.scale.y = marker.scale.z = 1.0;
  marker.color.a = 1.0F;
  if (chunk == nullptr) return marker;
  for (const auto& entry : *chunk) appendTriangles(*entry.mesh.load(), marker);
  return marker;
}

}  // namespace tsg::ros_interface
