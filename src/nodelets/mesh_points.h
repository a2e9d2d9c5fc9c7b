// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sensor_msgs/PointCloud2.h>

#include <cstdint>
#include <map>

#include "task_scene_graph/map/map.h"
#include "task_scene_graph/mapping/vertex_labels.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/object_conversions.h"

namespace tsg::nodelets {

/// The vertices of a map's mesh as points with the id of the object whose surface they are; as in
/// mesh.ply. @param object_of_primitive  of the map's primitives
inline sensor_msgs::PointCloud2 makeMeshPoints(
    const map::Map& map, const std::map<PrimitiveId, std::int32_t>& object_of_primitive) {
  const Mesh mesh = map::computeMesh(map);
  const auto labels =
      mapping::labelVertices(mesh, map.primitives(), object_of_primitive, map.meshVoxelSize());
  auto points = ros_interface::toPointCloud(mesh, labels, map.worldFrame());
  points.header.stamp = ros_interface::toRosTime(map.stamp());
  return points;
}

}  // namespace tsg::nodelets
