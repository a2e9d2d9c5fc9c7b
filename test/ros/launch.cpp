// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <std_srvs/Trigger.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "synthetic_robot.h"
#include "task_scene_graph/ros/mesh_update_conversions.h"

namespace tsg::test {
namespace {

/// What a follower of the topic knows of the mesh.
ros_interface::MeshUpdateReader read(const Recorder<msg::MeshUpdate>& updates) {
  ros_interface::MeshUpdateReader reader;
  for (const auto& update : updates.messages()) reader.apply(*update);
  return reader;
}

/// The triangles' corners, block by block.
std::vector<Eigen::Vector3f> listCorners(const ros_interface::MeshUpdateReader& reader) {
  std::vector<Eigen::Vector3f> corners;
  for (const auto& [block, mesh] : reader.blocks()) {
    for (const auto& triangle : mesh->triangles) {
      for (const auto index : triangle) corners.push_back(mesh->vertices[index]);
    }
  }
  return corners;
}

TEST(LaunchFile, RemappedTopicsReachTheChainAndTheMapIsSaved) {
  Recorder<msg::Tracks> tracks("/task_scene_graph/tracks");
  Recorder<msg::SceneGraph> graphs("/task_scene_graph/scene_graph");
  auto mesh_updates = std::make_unique<Recorder<msg::MeshUpdate>>("/task_scene_graph/mesh_blocks");
  Robot robot;
  // The last stage has started, so all have subscribed.
  const std::string save_map = "/task_scene_graph/scene_graph/save_map";
  ASSERT_TRUE(ros::service::waitForService(save_map, ros::Duration(60.0)));
  ASSERT_TRUE(tracks.waitForPublisher());
  ASSERT_TRUE(mesh_updates->waitForPublisher());
  ASSERT_TRUE(robot.waitForSubscribers(1));
  ASSERT_TRUE(robot.waitForSegmentationSubscribers(1));
  for (int i = 0; i < 10; ++i) {
    const RobotMessages messages = makeMessages(i);
    robot.publish(messages);
    ASSERT_TRUE(waitForTracks(tracks, messages)) << "frame " << i;
  }
  std_srvs::Trigger save;
  ASSERT_TRUE(ros::service::call(save_map, save));
  ASSERT_TRUE(save.response.success) << save.response.message;
  const std::string folder = save.response.message.substr(0, save.response.message.find('\n'));
  EXPECT_EQ(std::filesystem::path(folder).filename(), "tsg_launch_test");
  const auto summary = nlohmann::json::parse(std::ifstream(folder + "/summary.json"));
  EXPECT_EQ(summary.at("counts").at("objects"), 2);
  EXPECT_TRUE(
      graphs.waitFor([](const msg::SceneGraph& graph) { return graph.objects.size() == 2; }));

  const Stamp newest = makeMessages(9).stamp;
  ASSERT_TRUE(mesh_updates->waitFor([&](const msg::MeshUpdate& update) {
    return ros_interface::toStamp(update.header.stamp) == newest;
  }));
  const auto corners = listCorners(read(*mesh_updates));
  EXPECT_GT(corners.size(), 1000U);
  mesh_updates.reset();  // subscribers of one process share one connection
  Recorder<msg::MeshUpdate> late("/task_scene_graph/mesh_blocks");
  ASSERT_TRUE(late.waitFor([](const msg::MeshUpdate& update) { return update.is_last != 0; }));
  EXPECT_EQ(late.messages().front()->part, 1U);
  EXPECT_EQ(listCorners(read(late)), corners);
}

}  // namespace
}  // namespace tsg::test

int main(int argc, char** argv) { return tsg::test::runRosTests(argc, argv, "launch_test"); }
