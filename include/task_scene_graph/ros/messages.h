// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// This package's generated messages and services, as `task_scene_graph::msg::X`.
///
/// The generators put message X into the C++ namespace named after the package, where the core type
/// of the same name lies. Sources that need both therefore include messages through this header
/// only: it gives the generated code a namespace of its own. Type names on the wire and in bags
/// (string literals in the generated code) are not affected.
#include <geometry_msgs/Pose.h>
#include <ros/message_operations.h>
#include <ros/ros.h>
#include <sensor_msgs/Image.h>

#define task_scene_graph task_scene_graph_messages
#include <task_scene_graph/Finish.h>
#include <task_scene_graph/Mesh.h>
#include <task_scene_graph/ObjectPrimitives.h>
#include <task_scene_graph/PlaceGraph.h>
#include <task_scene_graph/SceneGraph.h>
#include <task_scene_graph/Segmentation.h>
#include <task_scene_graph/Tracks.h>
#undef task_scene_graph

namespace task_scene_graph {
namespace msg = ::task_scene_graph_messages;
}  // namespace task_scene_graph
