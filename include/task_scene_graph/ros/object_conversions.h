// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include <cstdint>
#include <string>
#include <vector>

#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/scene_graph/scene_graph.h"

namespace tsg::ros_interface {

/// The vertices of the primitives' meshes in the layout of pcl::PointXYZRGBL, so that
/// pcl::fromROSMsg() reads them; `label` is the primitive's id. Without a stamp. O(vertices).
/// @param frame  that the meshes are in
sensor_msgs::PointCloud2 toPointCloud(const std::vector<ObjectPrimitivePtr>& primitives,
                                      const std::string& frame);
/// The vertices of a mesh, in the same layout. @param labels  of each vertex. O(vertices).
/// @throws std::invalid_argument unless there is one for each.
sensor_msgs::PointCloud2 toPointCloud(const Mesh& mesh, const std::vector<std::int32_t>& labels,
                                      const std::string& frame);

/// A frame for each object of these tasks, "object_<id>", at the centre of its oriented box and
/// turned with it. O(objects * tasks).
/// @param tasks  "*" stands for all
tf2_msgs::TFMessage toObjectFrames(const scene_graph::SceneGraph& graph,
                                   const std::vector<std::string>& tasks, ros::Time stamp);

}  // namespace tsg::ros_interface
