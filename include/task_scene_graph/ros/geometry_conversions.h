// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/Point.h>
#include <geometry_msgs/Pose.h>
#include <geometry_msgs/Transform.h>
#include <ros/time.h>

#include <Eigen/Core>

#include "task_scene_graph/core/box.h"
#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/core/oriented_box.h"
#include "task_scene_graph/core/stamp.h"
#include "task_scene_graph/ros/messages.h"

namespace tsg::ros_interface {

/// Exact in both directions for every time that ROS knows. What a damaged message carries besides
/// (10^9 nanoseconds and more) is at most the last time that ROS knows, so that it can be sent on.
Stamp toStamp(const ::ros::Time& time);
/// @throws std::invalid_argument for a stamp before 0 or after the year 2106, which ROS 1 cannot
/// hold.
::ros::Time toRosTime(Stamp stamp);

/// The rotation is normalised. @throws std::invalid_argument if a value is not finite or the
/// quaternion has no length.
Pose toPose(const geometry_msgs::Transform& transform);
Pose toPose(const geometry_msgs::Pose& pose);
geometry_msgs::Transform toTransform(const Pose& pose);
geometry_msgs::Pose toPoseMessage(const Pose& pose);

Eigen::Vector3d toVector(const geometry_msgs::Point& point);
geometry_msgs::Point toPoint(const Eigen::Vector3d& vector);

/// Centre and full side lengths, metres; an empty box has size 0. The orientation is the identity.
msg::BoundingBox toBoundingBox(const Aabb& box);
msg::BoundingBox toBoundingBox(const OrientedBox& box);
/// The box with its turn about z; the turn's other parts must be 0. Empty for size 0.
OrientedBox toOrientedBox(const msg::BoundingBox& box);
/// The smallest axis-aligned box around the (possibly rotated) box; empty for size 0.
Aabb toAabb(const msg::BoundingBox& box);

}  // namespace tsg::ros_interface
