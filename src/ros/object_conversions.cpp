// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/object_conversions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace tsg::ros_interface {
namespace {

// The layout of pcl::PointXYZRGBL: two blocks of 16 bytes.
constexpr std::uint32_t kPointBytes = 32;
constexpr std::uint32_t kRgbOffset = 16;
constexpr std::uint32_t kLabelOffset = 20;

sensor_msgs::PointField makeField(const char* name, std::uint32_t offset, std::uint8_t type) {
  sensor_msgs::PointField field;
  field.name = name;
  field.offset = offset;
  field.datatype = type;
  field.count = 1;
  return field;
}

void writePoint(const Eigen::Vector3f& p_m, const std::array<std::uint8_t, 3>& rgb,
                std::uint32_t label, std::uint8_t* point) {
  std::memcpy(point, p_m.data(), 3 * sizeof(float));
  const float one = 1.0F;  // PCL's homogeneous coordinate
  std::memcpy(point + 3 * sizeof(float), &one, sizeof(float));
  const std::uint8_t bgra[4] = {rgb[2], rgb[1], rgb[0], 255};
  std::memcpy(point + kRgbOffset, bgra, sizeof(bgra));
  std::memcpy(point + kLabelOffset, &label, sizeof(label));
}

/// Of points that are still all zeros.
sensor_msgs::PointCloud2 makeCloud(std::size_t count, const std::string& frame) {
  using Field = sensor_msgs::PointField;
  sensor_msgs::PointCloud2 cloud;
  cloud.header.frame_id = frame;
  cloud.height = 1;
  cloud.width = static_cast<std::uint32_t>(count);
  cloud.fields = {makeField("x", 0, Field::FLOAT32), makeField("y", 4, Field::FLOAT32),
                  makeField("z", 8, Field::FLOAT32), makeField("rgb", kRgbOffset, Field::FLOAT32),
                  makeField("label", kLabelOffset, Field::UINT32)};
  cloud.point_step = kPointBytes;
  cloud.row_step = kPointBytes * cloud.width;
  cloud.is_dense = 1;
  cloud.data.assign(count * kPointBytes, 0);
  return cloud;
}

bool isChosen(const std::string& task, const std::vector<std::string>& tasks) {
  return std::any_of(tasks.begin(), tasks.end(),
                     [&](const std::string& chosen) { return chosen == "*" || chosen == task; });
}

}  // namespace

sensor_msgs::PointCloud2 toPointCloud(const std::vector<ObjectPrimitivePtr>& primitives,
                                      const std::string& frame) {
  std::size_t count = 0;
  for (const auto& primitive : primitives) count += primitive->mesh.vertices.size();
  sensor_msgs::PointCloud2 cloud = makeCloud(count, frame);
  std::uint8_t* next = cloud.data.data();
  for (const auto& primitive : primitives) {
    const auto label = static_cast<std::uint32_t>(primitive->id.value);
    for (std::size_t i = 0; i < primitive->mesh.vertices.size(); ++i) {
      writePoint(primitive->mesh.vertices[i], primitive->mesh.colors[i], label, next);
      next += kPointBytes;
    }
  }
  return cloud;
}

sensor_msgs::PointCloud2 toPointCloud(const Mesh& mesh, const std::vector<std::int32_t>& labels,
                                      const std::string& frame) {
  if (labels.size() != mesh.vertices.size()) {
    throw std::invalid_argument(std::to_string(labels.size()) + " labels, expected " +
                                std::to_string(mesh.vertices.size()) + " as there are vertices");
  }
  sensor_msgs::PointCloud2 cloud = makeCloud(labels.size(), frame);
  std::uint8_t* next = cloud.data.data();
  for (std::size_t i = 0; i < labels.size(); ++i, next += kPointBytes) {
    writePoint(mesh.vertices[i], mesh.colors[i], static_cast<std::uint32_t>(labels[i]), next);
  }
  return cloud;
}

tf2_msgs::TFMessage toObjectFrames(const scene_graph::SceneGraph& graph,
                                   const std::vector<std::string>& tasks, ros::Time stamp) {
  tf2_msgs::TFMessage frames;
  for (const auto& object : graph.objects) {
    if (!isChosen(object.task, tasks)) continue;
    const bool has_box = !object.oriented_box.isEmpty();
    const OrientedBox box = has_box ? object.oriented_box : toOrientedBox(object.box);
    geometry_msgs::TransformStamped frame;
    frame.header.stamp = stamp;
    frame.header.frame_id = graph.world_frame;
    frame.child_frame_id = "object_" + std::to_string(object.id.value);
    frame.transform.translation.x = box.center_m.x();
    frame.transform.translation.y = box.center_m.y();
    frame.transform.translation.z = box.center_m.z();
    frame.transform.rotation.z = std::sin(box.yaw_rad / 2.0);
    frame.transform.rotation.w = std::cos(box.yaw_rad / 2.0);
    frames.transforms.push_back(frame);
  }
  return frames;
}

}  // namespace tsg::ros_interface
