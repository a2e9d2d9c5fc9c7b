// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <nodelet/NodeletList.h>
#include <ros/network.h>
#include <std_srvs/Trigger.h>
#include <sys/wait.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <unistd.h>
#include <visualization_msgs/MarkerArray.h>
#include <xmlrpcpp/XmlRpcClient.h>

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

/// Whether a node is connected to a publisher of a topic.
bool isConnected(const std::string& node, const std::string& topic) {
  XmlRpc::XmlRpcValue request;
  request[0] = ros::this_node::getName();
  request[1] = node;
  XmlRpc::XmlRpcValue response;
  XmlRpc::XmlRpcValue uri;
  if (!ros::master::execute("lookupNode", request, response, uri, false)) return false;
  std::string host;
  std::uint32_t port = 0;
  ros::network::splitURI(uri, host, port);
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port), "/");
  XmlRpc::XmlRpcValue caller;
  caller[0] = ros::this_node::getName();
  XmlRpc::XmlRpcValue result;
  if (!client.execute("getBusInfo", caller, result)) return false;
  for (int i = 0; i < result[2].size(); ++i) {  // number, peer, direction, transport, topic
    XmlRpc::XmlRpcValue& link = result[2][i];
    if (std::string(link[2]) == "i" && std::string(link[4]) == topic) return true;
  }
  return false;
}

using Commands = std::vector<std::vector<std::string>>;

/// The chain as the launch file runs it, in a process of its own.
Commands makeChain() { return {{findProgram("chain_node"), "--recorded-segmentation"}}; }

/// Each stage in a process of its own.
Commands makeSeparateNodes() {
  return {{findProgram("tracker_node")},
          {findProgram("mesh_fusion_node")},
          {findProgram("scene_graph_node")}};
}

/// The stages loaded into the nodelet manager of this name, as the launch file does with manager:=.
Commands makeLoaders(const std::string& manager) {
  Commands commands;
  for (const auto& [name, type] : {std::pair{"tracker", "Tracker"},
                                   {"mesh_fusion", "MeshFusion"},
                                   {"scene_graph", "SceneGraph"}}) {
    commands.push_back({"rosrun", "task_scene_graph", "load_into_manager",
                        std::string("task_scene_graph/") + type, manager,
                        std::string("__name:=") + name});
  }
  return commands;
}

/// The chain, started by one command or several.
class ChainProgram {
 public:
  /// @param num_processes  that the stages with images run in
  explicit ChainProgram(const Commands& commands = makeChain(), std::uint32_t num_processes = 1)
      : num_processes_(num_processes) {
    setChainParameters(folder_.path(), map());
    geometry_msgs::TransformStamped T_earth_world;
    T_earth_world.header.frame_id = "earth";
    T_earth_world.child_frame_id = "world";
    T_earth_world.transform.rotation.w = 1.0;
    earth_.sendTransform(T_earth_world);
    for (const auto& command : commands) pids_.push_back(startProgram(command));
  }
  /// Ends one of the programs as a crash does, and starts it again.
  void crash(std::size_t index, const std::vector<std::string>& command) {
    kill(pids_[index], SIGKILL);
    waitForExit(pids_[index]);
    pids_[index] = startProgram(command);
  }
  static std_srvs::TriggerResponse save() {
    std_srvs::Trigger call;
    EXPECT_TRUE(ros::service::call("/scene_graph/save_map", call));
    return call.response;
  }
  ~ChainProgram() { interrupt(); }
  std::string map() const { return (folder_.path() / "map").string(); }

  void play(
      int num_frames,
      const std::function<RobotMessages(int)>& make = [](int i) { return makeMessages(i); }) {
    // The last stage has started, so all have subscribed.
    ASSERT_TRUE(ros::service::waitForService("/scene_graph/save_map", ros::Duration(60.0)));
    ASSERT_TRUE(tracks_.waitForPublisher());
    ASSERT_TRUE(robot_.waitForSubscribers(num_processes_));
    ASSERT_TRUE(robot_.waitForSegmentationSubscribers(num_processes_));
    ASSERT_TRUE(waitForStages());
    for (int i = 0; i < num_frames; ++i) {
      const RobotMessages messages = make(i);
      robot_.publish(messages);
      ASSERT_TRUE(waitForTracks(tracks_, messages)) << "frame " << i;
    }
  }
  std::size_t numLiveTracks() const { return tracks_.messages().back()->live.size(); }
  /// As Ctrl-C, which all get at once; the highest exit status.
  int interrupt() {
    for (const pid_t pid : pids_) kill(pid, SIGINT);
    int status = 0;
    for (const pid_t pid : pids_) status = std::max(status, waitForExit(pid));
    pids_.clear();
    return status;
  }
  nlohmann::json readSummary() const {
    return nlohmann::json::parse(std::ifstream(map() + "/summary.json"));
  }
  std::string readFile(const std::string& name) const {
    std::ifstream file(map() + "/" + name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

 private:
  /// What a stage says before the next one is connected to it, this one never hears.
  bool waitForStages() const {
    if (num_processes_ < 2) return true;
    return waitUntil([] {
      return isConnected("/mesh_fusion", "/tracks") &&
             isConnected("/scene_graph", "/object_primitives") &&
             isConnected("/scene_graph", "/place_graph");
    });
  }

  TemporaryFolder folder_;
  Recorder<msg::Tracks> tracks_{"tracks"};
  Robot robot_;
  tf2_ros::StaticTransformBroadcaster
      earth_;  ///< the map's frame has another name than the robot's
  std::uint32_t num_processes_;
  std::vector<pid_t> pids_;
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

std::size_t countPrimitives(const ChainProgram& chain) {
  return chain.readSummary().at("counts").at("primitives").get<std::size_t>();
}

TEST(Shutdown, InterruptOfSeparateProcessesLeavesACompleteMap) {
  ChainProgram chain(makeSeparateNodes(), 2);
  ASSERT_NO_FATAL_FAILURE(chain.play(12));
  ASSERT_GE(chain.numLiveTracks(), 2U);
  EXPECT_EQ(chain.interrupt(), 0);
  EXPECT_EQ(chain.readSummary().at("counts").at("objects"), 2);
  const std::string mesh = chain.readFile("mesh.ply");
  EXPECT_NE(mesh.find("object_id"), std::string::npos);
}

TEST(Shutdown, AStageThatWasStartedAnewIsNamedWhenTheMapIsSaved) {
  const Commands nodes = makeSeparateNodes();
  ChainProgram chain(nodes, 2);
  ASSERT_NO_FATAL_FAILURE(chain.play(20));
  ASSERT_TRUE(ChainProgram::save().success);
  chain.crash(1, nodes[1]);
  ASSERT_TRUE(ros::service::waitForService("/mesh_fusion/save_map_part", ros::Duration(60.0)));
  ASSERT_NO_FATAL_FAILURE(chain.play(20, [](int i) { return makeMessages(i, 200.0); }));
  const auto saved = ChainProgram::save();
  EXPECT_FALSE(saved.success);
  EXPECT_NE(saved.message.find("/mesh_fusion: was started anew"), std::string::npos)
      << saved.message;
  EXPECT_NE(saved.message.find("lack the first 100.0 s"), std::string::npos) << saved.message;
  EXPECT_EQ(chain.interrupt(), 0);
}

TEST(Shutdown, InterruptOfStagesInAManagerOfOthersLeavesACompleteMapAndTheManager) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the manager of others is built without the sanitizer that our nodelets need";
#endif
  const pid_t manager =
      startProgram({"rosrun", "nodelet", "nodelet", "manager", "__name:=camera_manager"});
  ChainProgram chain(makeLoaders("/camera_manager"));
  ASSERT_NO_FATAL_FAILURE(chain.play(12));
  ASSERT_GE(chain.numLiveTracks(), 2U);
  EXPECT_EQ(chain.interrupt(), 0);
  EXPECT_EQ(chain.readSummary().at("counts").at("objects"), 2);
  EXPECT_NE(chain.readFile("mesh.ply").find("object_id"), std::string::npos);
  EXPECT_EQ(waitpid(manager, nullptr, WNOHANG), 0) << "the manager has ended";
  nodelet::NodeletList list;
  ASSERT_TRUE(ros::service::call("/camera_manager/list", list));
  EXPECT_TRUE(list.response.nodelets.empty());
  kill(manager, SIGINT);
  EXPECT_EQ(waitForExit(manager), 0);
}

TEST(Shutdown, InterruptWithABacklogOfAHundredTracksLosesNone) {
  const auto grid = [](int i) { return makeGridMessages(i); };
  ChainProgram saved;
  ASSERT_NO_FATAL_FAILURE(saved.play(8, grid));
  ASSERT_GE(saved.numLiveTracks(), 100U);
  std_srvs::Trigger save;
  ASSERT_TRUE(ros::service::call("/scene_graph/save_map", save));
  ASSERT_TRUE(save.response.success) << save.response.message;
  const std::size_t expected = countPrimitives(saved);
  EXPECT_GE(expected, 80U);
  EXPECT_EQ(saved.interrupt(), 0);
  EXPECT_EQ(countPrimitives(saved), expected);
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
  EXPECT_GT(primitives.messages().back()->sequence, 0U);  // it has what was sent before it came
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
