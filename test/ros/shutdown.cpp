// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <std_srvs/Trigger.h>
#include <sys/wait.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <unistd.h>
#include <visualization_msgs/MarkerArray.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "support.h"
#include "synthetic_robot.h"

namespace tsg::test {
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

/// A program of this package: it lies beside this one.
std::string findProgram(const std::string& name) {
  return (std::filesystem::read_symlink("/proc/self/exe").parent_path() / name).string();
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

/// The chain as the launch file runs it, in a process of its own.
class ChainProgram {
 public:
  ChainProgram() {
    const std::string tasks = (folder_.path() / "objects.yaml").string();
    writeTaskFile(tasks, {"red box", "blue box"}, 0);
    ros::param::set("/scene_graph/object_tasks", tasks);
    ros::param::set("/scene_graph/output", map());
    ros::param::set("/mesh_fusion/output", map());
    geometry_msgs::TransformStamped T_earth_world;
    T_earth_world.header.frame_id = "earth";
    T_earth_world.child_frame_id = "world";
    T_earth_world.transform.rotation.w = 1.0;
    earth_.sendTransform(T_earth_world);
    pid_ = startProgram({findProgram("chain_node"), "--recorded-segmentation"});
  }
  ~ChainProgram() {
    if (pid_ > 0) interrupt();
  }
  std::string map() const { return (folder_.path() / "map").string(); }

  void play(int num_frames) {
    // The last stage has started, so all have subscribed.
    ASSERT_TRUE(ros::service::waitForService("/scene_graph/save_map", ros::Duration(60.0)));
    ASSERT_TRUE(tracks_.waitForPublisher());
    ASSERT_TRUE(robot_.waitForSubscribers(1));
    ASSERT_TRUE(robot_.waitForSegmentationSubscribers(1));
    for (int i = 0; i < num_frames; ++i) {
      const RobotMessages messages = makeMessages(i);
      robot_.publish(messages);
      ASSERT_TRUE(tracks_.waitFor([&](const msg::Tracks& message) {
        return ros_interface::toStamp(message.header.stamp) == messages.stamp;
      })) << "frame "
          << i;
    }
  }
  std::size_t numLiveTracks() const { return tracks_.messages().back()->live.size(); }
  /// As Ctrl-C; the exit status.
  int interrupt() {
    kill(pid_, SIGINT);
    const int status = waitForExit(pid_);
    pid_ = 0;
    return status;
  }

 private:
  TemporaryFolder folder_;
  Recorder<msg::Tracks> tracks_{"tracks"};
  Robot robot_;
  tf2_ros::StaticTransformBroadcaster
      earth_;  ///< the map's frame has another name than the robot's
  pid_t pid_ = 0;
};

TEST(Shutdown, InterruptEndsLiveTracksAndLeavesACompleteMap) {
  ChainProgram chain;
  ASSERT_NO_FATAL_FAILURE(chain.play(12));
  ASSERT_GE(chain.numLiveTracks(), 2U);
  EXPECT_EQ(chain.interrupt(), 0);
  const auto summary = nlohmann::json::parse(std::ifstream(chain.map() + "/summary.json"));
  EXPECT_NE(summary.dump().find("red box"), std::string::npos);
  EXPECT_NE(summary.dump().find("blue box"), std::string::npos);
  EXPECT_EQ(summary.at("frame"), "earth");
  std::ifstream ply(chain.map() + "/mesh.ply", std::ios::binary);
  std::string first_line;
  std::getline(ply, first_line);
  EXPECT_EQ(first_line, "ply");
}

TEST(Shutdown, LateSubscriberGetsAllPrimitivesAndTheWholeMesh) {
  ChainProgram chain;
  ASSERT_NO_FATAL_FAILURE(chain.play(8));
  std_srvs::Trigger save;
  ASSERT_TRUE(ros::service::call("/scene_graph/save_map", save));
  ASSERT_TRUE(save.response.success) << save.response.message;
  Recorder<msg::ObjectPrimitives> primitives("object_primitives");
  EXPECT_TRUE(primitives.waitFor(
      [](const msg::ObjectPrimitives& message) { return message.primitives.size() >= 2; }));
  Recorder<visualization_msgs::MarkerArray> mesh("mesh");
  EXPECT_TRUE(mesh.waitFor([](const visualization_msgs::MarkerArray& message) {
    return !message.markers.empty() && !message.markers[0].points.empty();
  }));
  Recorder<msg::SceneGraph> graph("scene_graph");
  EXPECT_TRUE(
      graph.waitFor([](const msg::SceneGraph& message) { return message.objects.size() == 2; }));
  EXPECT_EQ(chain.interrupt(), 0);
}

TEST(Shutdown, NodeWithAMisspeltParameterEndsWithStatusOne) {
  ros::param::set("/misspelt_tracker/windows_s", 3.0);
  const pid_t pid = startProgram({findProgram("tracker_node"), "__name:=misspelt_tracker"});
  EXPECT_EQ(waitForExit(pid), 1);
}

}  // namespace
}  // namespace tsg::test

int main(int argc, char** argv) { return tsg::test::runRosTests(argc, argv, "shutdown_test"); }
