// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/detections.h"

#include <geometry_msgs/PoseWithCovariance.h>
#include <gtest/gtest.h>
#include <sensor_msgs/PointCloud2.h>

#include <vector>

namespace tsg::ros_interface {
namespace {

// The fields of vision_msgs (ROS 1), which need not be installed.
struct Result {
  std::int64_t id = 0;
  double score = 0.0;
  geometry_msgs::PoseWithCovariance pose;
};
struct Box {
  geometry_msgs::Pose center;
  geometry_msgs::Vector3 size;
};
struct Detection {
  std_msgs::Header header;
  std::vector<Result> results;
  Box bbox;
  sensor_msgs::PointCloud2 source_cloud;
};
struct DetectionArray {
  std_msgs::Header header;
  std::vector<Detection> detections;
};

TEST(Detections, AreTheObjectsWithTheIdsOfTheirTasks) {
  scene_graph::SceneGraph graph;
  graph.world_frame = "map";
  graph.stamp = {2500000000};
  for (const char* task : {"sit", "read", "sit"}) {
    scene_graph::SceneObject object;
    object.task = task;
    object.score = 0.25;
    object.oriented_box = {{1.0, 2.0, 3.0}, {0.5, 0.25, 2.0}, 0.5};
    graph.objects.push_back(object);
  }
  TaskNumbers numbers;
  numbers.find("read");
  const auto message = toDetections<DetectionArray>(graph, numbers);
  EXPECT_EQ(message.header.frame_id, "map");
  EXPECT_EQ(message.header.stamp.nsec, 500000000U);
  ASSERT_EQ(message.detections.size(), 3U);
  const Detection& first = message.detections.front();
  EXPECT_EQ(first.header.frame_id, "map");
  EXPECT_EQ(first.bbox.center.position.z, 3.0);
  EXPECT_NEAR(first.bbox.center.orientation.z, std::sin(0.25), 1e-12);
  EXPECT_EQ(first.bbox.size.y, 0.25);
  ASSERT_EQ(first.results.size(), 1U);
  EXPECT_EQ(first.results[0].id, 2);
  EXPECT_EQ(first.results[0].score, 0.25);
  EXPECT_EQ(first.results[0].pose.pose.position.x, 1.0);
  EXPECT_EQ(message.detections[1].results[0].id, 1);
  EXPECT_EQ(message.detections[2].results[0].id, 2);
}

}  // namespace
}  // namespace tsg::ros_interface
