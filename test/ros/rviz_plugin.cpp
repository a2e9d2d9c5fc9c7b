// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <ros/ros.h>
#include <rviz/display.h>

#include <algorithm>
#include <pluginlib/class_loader.hpp>

namespace tsg::test {
namespace {

constexpr const char* kClass = "task_scene_graph/Mesh";

TEST(RvizPlugin, RvizFindsTheDisplay) {
  pluginlib::ClassLoader<rviz::Display> loader("rviz", "rviz::Display");
  const auto classes = loader.getDeclaredClasses();
  EXPECT_EQ(std::count(classes.begin(), classes.end(), kClass), 1);
  EXPECT_EQ(loader.getClassPackage(kClass), "task_scene_graph");
  EXPECT_FALSE(loader.getClassDescription(kClass).empty());
}

TEST(RvizPlugin, TheLibraryGivesADisplayWithItsProperties) {
  pluginlib::ClassLoader<rviz::Display> loader("rviz", "rviz::Display");
  const boost::shared_ptr<rviz::Display> display = loader.createInstance(kClass);
  ASSERT_NE(display, nullptr);
  EXPECT_EQ(display->subProp("Alpha")->getValue().toFloat(), 1.0F);
  EXPECT_EQ(display->subProp("Color By")->getValue().toString().toStdString(), "Camera");
  EXPECT_TRUE(display->subProp("Back Faces")->getValue().toBool());
  display->setTopic("/somewhere/mesh_blocks", "task_scene_graph/MeshUpdate");
  EXPECT_EQ(display->subProp("Topic")->getValue().toString().toStdString(),
            "/somewhere/mesh_blocks");
}

}  // namespace
}  // namespace tsg::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "rviz_plugin_test");
  return RUN_ALL_TESTS();
}
