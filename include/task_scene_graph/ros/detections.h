// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/task_numbers.h"
#include "task_scene_graph/scene_graph/scene_graph.h"

namespace tsg::ros_interface {

/// The objects as vision_msgs/Detection3DArray: each has one hypothesis, whose id is that of its
/// task in TasksInForce, whose score is the object's, and whose pose is the box's. No cloud. A
/// template, since the package vision_msgs need not be there. O(objects).
template <typename Detection3DArray>
Detection3DArray toDetections(const scene_graph::SceneGraph& graph, TaskNumbers& numbers) {
  Detection3DArray message;
  message.header.frame_id = graph.world_frame;
  message.header.stamp = toRosTime(graph.stamp);
  for (const auto& object : graph.objects) {
    message.detections.emplace_back();
    auto& detection = message.detections.back();
    const msg::BoundingBox box = toBoundingBox(object.oriented_box);
    detection.header = message.header;
    detection.bbox.center = box.pose;
    detection.bbox.size = box.size;
    detection.results.emplace_back();
    auto& result = detection.results.back();
    result.id = static_cast<decltype(result.id)>(numbers.find(object.task));
    result.score = object.score;
    result.pose.pose = box.pose;
  }
  return message;
}

}  // namespace tsg::ros_interface
