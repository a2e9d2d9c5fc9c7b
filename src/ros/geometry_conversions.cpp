// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/geometry_conversions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace tsg::ros_interface {
namespace {

constexpr std::int64_t kNsPerSecond = 1000000000;

Eigen::Quaterniond toRotation(const geometry_msgs::Quaternion& q) {
  const Eigen::Quaterniond rotation(q.w, q.x, q.y, q.z);
  const double norm = rotation.norm();
  if (std::isfinite(norm) && norm > 0.5 && norm < 2.0) return rotation.normalized();
  std::ostringstream text;
  text << "rotation (" << q.x << ", " << q.y << ", " << q.z << ", " << q.w
       << ") is not a quaternion of length 1";
  throw std::invalid_argument(text.str());
}

}  // namespace

Stamp toStamp(const ::ros::Time& time) {
  // A message may carry 10^9 ns and more; the last of all seconds has no next one.
  constexpr std::int64_t kLast_ns =
      static_cast<std::int64_t>(std::numeric_limits<std::uint32_t>::max()) * kNsPerSecond +
      kNsPerSecond - 1;
  const std::int64_t ns =
      static_cast<std::int64_t>(time.sec) * kNsPerSecond + static_cast<std::int64_t>(time.nsec);
  return {std::min(ns, kLast_ns)};
}

::ros::Time toRosTime(Stamp stamp) {
  const std::int64_t seconds = stamp.ns / kNsPerSecond;
  if (stamp.ns < 0 || seconds > std::numeric_limits<std::uint32_t>::max()) {
    throw std::invalid_argument("stamp " + std::to_string(stamp.ns) +
                                " ns does not fit into a ROS time, expected [0, 2^32) s");
  }
  return {static_cast<std::uint32_t>(seconds), static_cast<std::uint32_t>(stamp.ns % kNsPerSecond)};
}

Pose toPose(const geometry_msgs::Transform& transform) {
  Pose pose = Pose::Identity();
  pose.linear() = toRotation(transform.rotation).toRotationMatrix();
  pose.translation() << transform.translation.x, transform.translation.y, transform.translation.z;
  if (!pose.translation().allFinite()) {
    throw std::invalid_argument("translation has a value that is not finite");
  }
  return pose;
}

geometry_msgs::Transform toTransform(const Pose& pose) {
  const Eigen::Quaterniond rotation(pose.linear());
  geometry_msgs::Transform transform;
  transform.translation.x = pose.translation().x();
  transform.translation.y = pose.translation().y();
  transform.translation.z = pose.translation().z();
  transform.rotation.x = rotation.x();
  transform.rotation.y = rotation.y();
  transform.rotation.z = rotation.z();
  transform.rotation.w = rotation.w();
  return transform;
}

Pose toPose(const geometry_msgs::Pose& pose) {
  geometry_msgs::Transform transform;
  transform.translation.x = pose.position.x;
  transform.translation.y = pose.position.y;
  transform.translation.z = pose.position.z;
  transform.rotation = pose.orientation;
  return toPose(transform);
}

geometry_msgs::Pose toPoseMessage(const Pose& pose) {
  const geometry_msgs::Transform transform = toTransform(pose);
  geometry_msgs::Pose message;
  message.position.x = transform.translation.x;
  message.position.y = transform.translation.y;
  message.position.z = transform.translation.z;
  message.orientation = transform.rotation;
  return message;
}

Eigen::Vector3d toVector(const geometry_msgs::Point& point) { return {point.x, point.y, point.z}; }

geometry_msgs::Point toPoint(const Eigen::Vector3d& vector) {
  geometry_msgs::Point point;
  point.x = vector.x();
  point.y = vector.y();
  point.z = vector.z();
  return point;
}

msg::BoundingBox toBoundingBox(const Aabb& box) {
  msg::BoundingBox message;
  message.pose.orientation.w = 1.0;
  if (box.isEmpty()) return message;
  message.pose.position = toPoint(box.center());
  message.size.x = box.sizes().x();
  message.size.y = box.sizes().y();
  message.size.z = box.sizes().z();
  return message;
}

msg::BoundingBox toBoundingBox(const OrientedBox& box) {
  msg::BoundingBox message;
  message.pose.position = toPoint(box.center_m);
  message.pose.orientation.z = std::sin(0.5 * box.yaw_rad);
  message.pose.orientation.w = std::cos(0.5 * box.yaw_rad);
  message.size.x = box.size_m.x();
  message.size.y = box.size_m.y();
  message.size.z = box.size_m.z();
  return message;
}

OrientedBox toOrientedBox(const msg::BoundingBox& box) {
  const auto& turn = box.pose.orientation;
  return {toVector(box.pose.position),
          {box.size.x, box.size.y, box.size.z},
          2.0 * std::atan2(turn.z, turn.w)};
}

Aabb toAabb(const msg::BoundingBox& box) {
  const Eigen::Vector3d size(box.size.x, box.size.y, box.size.z);
  if (size.isZero()) return {};
  const Eigen::Vector3d center = toVector(box.pose.position);
  const Eigen::Matrix3d rotation = toRotation(box.pose.orientation).toRotationMatrix();
  const Eigen::Vector3d half = rotation.cwiseAbs() * size * 0.5;
  return {center - half, center + half};
}

}  // namespace tsg::ros_interface
