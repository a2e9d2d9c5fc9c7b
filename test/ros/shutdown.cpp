// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "support.h"
#include "synthetic_robot.h"

namespace task_scene_graph::test {
namespace {

pid_t startProgram(const std::vector<std::string>& arguments) {
  const pid_t pid = fork();
  if (pid != 0) return pid;
  std::vector<char*> argv;
  for (const auto& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  execvp(argv[0], argv.data());
  _exit(127);
}

/// The exit status, or -1 if the program does not end in time (it is killed then).
int waitForExit(pid_t pid) {
  int status = 0;
  const bool is_over = waitUntil([&] { return waitpid(pid, &status, WNOHANG) == pid; });
  if (!is_over) {
    kill(pid, SIGKILL);
    waitpid(pid, &status, 0);
    return -1;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

TEST(Shutdown, InterruptEndsLiveTracksAndLeavesACompleteMap) {
  const TemporaryFolder folder;
  const std::string map = (folder.path() / "map").string();
  writeTaskFile((folder.path() / "objects.yaml").string(), {"red box", "blue box"}, 0);
  ros::param::set("/scene_graph/object_tasks", (folder.path() / "objects.yaml").string());
  ros::param::set("/scene_graph/output", map);
  ros::param::set("/mesh_fusion/output", map);
  Recorder<msg::Tracks> tracks("tracks");
  Robot robot;
  const pid_t pid = startProgram({"rosrun", "task_scene_graph", "chain_node",
                                  "--recorded-segmentation"});
  ASSERT_TRUE(robot.waitForSubscribers(1));
  ASSERT_TRUE(robot.waitForSegmentationSubscribers(1));
  ASSERT_TRUE(tracks.waitForPublisher());
  for (int i = 0; i < 12; ++i) {
    const RobotMessages messages = makeMessages(i);
    robot.publish(messages);
    ASSERT_TRUE(tracks.waitFor([&](const msg::Tracks& message) {
      return ros_interface::toStamp(message.header.stamp) == messages.stamp;
    })) << "frame "
        << i;
  }
  ASSERT_EQ(tracks.messages().back()->live.size(), 2U);
  kill(pid, SIGINT);
  EXPECT_EQ(waitForExit(pid), 0);
  const auto summary = nlohmann::json::parse(std::ifstream(map + "/summary.json"));
  EXPECT_NE(summary.dump().find("red box"), std::string::npos);
  EXPECT_NE(summary.dump().find("blue box"), std::string::npos);
  std::ifstream ply(map + "/mesh.ply", std::ios::binary);
  std::string first_line;
  std::getline(ply, first_line);
  EXPECT_EQ(first_line, "ply");
}

TEST(Shutdown, NodeWithAMisspeltParameterEndsWithStatusOne) {
  ros::param::set("/misspelt_tracker/windows_s", 3.0);
  const pid_t pid = startProgram({"rosrun", "task_scene_graph", "tracker_node",
                                  "__name:=misspelt_tracker"});
  EXPECT_EQ(waitForExit(pid), 1);
}

}  // namespace
}  // namespace task_scene_graph::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "shutdown_test");
  ros::AsyncSpinner spinner(2);
  spinner.start();
  const int result = RUN_ALL_TESTS();
  spinner.stop();
  ros::shutdown();
  return result;
}
