// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/object_conversions.h"

#include <gtest/gtest.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <memory>

namespace tsg::ros_interface {
namespace {

ObjectPrimitivePtr makePrimitive(std::uint64_t id) {
  auto primitive = std::make_shared<ObjectPrimitive>();
  primitive->id = {id};
  const auto x_m = static_cast<float>(id);
  primitive->mesh.vertices = {{x_m, 2, 3}, {x_m, 5, 6}};
  primitive->mesh.colors = {{255, 128, 1}, {7, 8, 9}};
  return primitive;
}

TEST(ObjectPointCloud, HoldsEveryVertexWithItsColourAndPrimitive) {
  const auto cloud = toPointCloud({makePrimitive(4), makePrimitive(9)}, "map");
  EXPECT_EQ(cloud.header.frame_id, "map");
  ASSERT_EQ(cloud.width * cloud.height, 4U);
  ASSERT_EQ(cloud.data.size(), 4U * cloud.point_step);
  sensor_msgs::PointCloud2ConstIterator<float> x(cloud, "x");
  sensor_msgs::PointCloud2ConstIterator<float> y(cloud, "y");
  sensor_msgs::PointCloud2ConstIterator<std::uint8_t> r(cloud, "r");
  sensor_msgs::PointCloud2ConstIterator<std::uint8_t> g(cloud, "g");
  sensor_msgs::PointCloud2ConstIterator<std::uint8_t> b(cloud, "b");
  sensor_msgs::PointCloud2ConstIterator<std::uint32_t> label(cloud, "label");
  EXPECT_EQ(*x, 4.0F);
  EXPECT_EQ(*y, 2.0F);
  EXPECT_EQ(*r, 255);
  EXPECT_EQ(*g, 128);
  EXPECT_EQ(*b, 1);
  EXPECT_EQ(*label, 4U);
  x += 3;
  y += 3;
  b += 3;
  label += 3;
  EXPECT_EQ(*x, 9.0F);
  EXPECT_EQ(*y, 5.0F);
  EXPECT_EQ(*b, 9);
  EXPECT_EQ(*label, 9U);
}

TEST(ObjectPointCloud, OfNothingIsEmpty) { EXPECT_TRUE(toPointCloud({}, "map").data.empty()); }

TEST(ObjectFrames, AreAtTheBoxesOfTheChosenTasksAndTurnedWithThem) {
  scene_graph::SceneGraph graph;
  graph.world_frame = "map";
  for (std::uint64_t id = 1; id <= 2; ++id) {
    scene_graph::SceneObject object;
    object.id = {id};
    object.task = id == 1 ? "mug" : "book";
    object.oriented_box = {{1.0, 2.0, 3.0}, {0.1, 0.2, 0.3}, 0.5};
    graph.objects.push_back(object);
  }
  const auto chosen = toObjectFrames(graph, {"mug"}, ros::Time(7.0));
  ASSERT_EQ(chosen.transforms.size(), 1U);
  const auto& frame = chosen.transforms.front();
  EXPECT_EQ(frame.header.frame_id, "map");
  EXPECT_EQ(frame.child_frame_id, "object_1");
  EXPECT_EQ(frame.header.stamp, ros::Time(7.0));
  EXPECT_EQ(frame.transform.translation.z, 3.0);
  EXPECT_DOUBLE_EQ(frame.transform.rotation.w, std::cos(0.25));
  EXPECT_DOUBLE_EQ(frame.transform.rotation.z, std::sin(0.25));
  EXPECT_EQ(toObjectFrames(graph, {"*"}, ros::Time(7.0)).transforms.size(), 2U);
  EXPECT_TRUE(toObjectFrames(graph, {"cup"}, ros::Time(7.0)).transforms.empty());
}

}  // namespace
}  // namespace tsg::ros_interface
