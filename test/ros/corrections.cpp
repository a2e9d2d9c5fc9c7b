// SPDX-License-Identifier: BSD-3-Clause
// A robot whose odometry drifts, and a SLAM system that says so: the map follows.
#include <gtest/gtest.h>
#include <nav_msgs/Path.h>
#include <std_srvs/Trigger.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <limits>
#include <set>

#include "background_stage.h"
#include "correction_stage.h"
#include "support.h"
#include "synthetic_robot.h"
#include "task_scene_graph/map/files.h"

namespace tsg::test {
namespace {

namespace fs = std::filesystem;

constexpr int kNumFrames = 20;  ///< of a pass
constexpr const char* kApplied = "corrections: applied";
constexpr const char* kRefused = "corrections: refused";

Pose makePose(double x_m, double y_m, double yaw_rad) {
  Pose pose = Pose::Identity();
  pose.translation() = Eigen::Vector3d(x_m, y_m, 0.0);
  pose.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return pose;
}

/// What the odometry has gone wrong by on the second pass and after.
const Pose kDrift = makePose(0.1, 0.8, 0.04);

geometry_msgs::PoseStamped toPoseStamped(Stamp stamp, const Pose& pose) {
  const auto transform = ros_interface::toTransform(pose);
  geometry_msgs::PoseStamped message;
  message.header.stamp = ros_interface::toRosTime(stamp);
  message.pose.position.x = transform.translation.x;
  message.pose.position.y = transform.translation.y;
  message.pose.position.z = transform.translation.z;
  message.pose.orientation = transform.rotation;
  return message;
}

/// The true poses of both passes, each second one.
nav_msgs::Path makeTruePath() {
  nav_msgs::Path path;
  path.header.frame_id = "world";
  for (const double start_s : {100.0, 110.0}) {
    for (int i = 0; i < kNumFrames; i += i + 2 == kNumFrames ? 1 : 2) {
      path.poses.push_back(toPoseStamped(Stamp::fromSeconds(start_s + 0.1 * i), computePose(i)));
    }
  }
  return path;
}

class Chain {
 public:
  Chain(const fs::path& folder, const fs::path& output) {
    setChainParameters(folder, output.string());
    follow("", "");
    ros::param::set("/tracker/input/world_frame", "world");
  }
  static void follow(const std::string& odometry_frame, const std::string& path_topic) {
    ros::param::set("/mesh_fusion/corrections/odometry_frame", odometry_frame);
    ros::param::set("/mesh_fusion/corrections/path_topic", path_topic);
  }
  void start() { startStages(loader_, robot_, tracks_, graphs_); }
  /// Each once the tracker has answered to it. @param odometry  of the true pose: what is said
  void play(int first, int end, double start_s, const Pose& odometry,
            const std::string& frame = "world") {
    for (int i = first; i < end; ++i) {
      RobotMessages messages = makeMessages(i, start_s);
      messages.transform.header.frame_id = frame;
      messages.transform.transform = ros_interface::toTransform(odometry * computePose(i));
      robot_.publish(messages);
      ASSERT_TRUE(waitForTracks(tracks_, messages)) << i;
    }
  }
  /// What the map's frame is for the odometry from this moment on.
  void sendOdometry(double at_s, const Pose& T_world_odom) {
    geometry_msgs::TransformStamped transform;
    transform.header.stamp = ros::Time(at_s);
    transform.header.frame_id = "world";
    transform.child_frame_id = "odom";
    transform.transform = ros_interface::toTransform(T_world_odom);
    tf_.sendTransform(transform);
  }
  void sendPath(const nav_msgs::Path& path) {
    ASSERT_TRUE(waitUntil([&] { return path_.getNumSubscribers() > 0; }));
    path_.publish(path);
  }
  bool waitForLine(const std::string& key, const std::string& beginning) {
    return waitUntil([&] { return findLine(key).compare(0, beginning.size(), beginning) == 0; });
  }
  std::string findLine(const std::string& key) const {
    const auto lines = findDiagnostics(diagnostics_, "mesh_fusion");
    const auto line = lines.find(key);
    return line == lines.end() ? "" : line->second;
  }
  std::string findDropped() const {
    for (const auto& [key, value] : findDiagnostics(diagnostics_, "mesh_fusion")) {
      if (key.find("queue full") != std::string::npos) return key + ": " + value;
    }
    return "";
  }
  bool waitForObjects(std::size_t count) {
    return waitUntil([&] {
      const auto all = graphs_.messages();
      return !all.empty() && all.back()->objects.size() == count;
    });
  }
  static std_srvs::TriggerResponse save() {
    std_srvs::Trigger call;
    EXPECT_TRUE(ros::service::call("/scene_graph/save_map", call));
    EXPECT_TRUE(call.response.success) << call.response.message;
    return call.response;
  }
  const Recorder<msg::SceneGraph>& graphs() const { return graphs_; }
  Recorder<rosgraph_msgs::Log>& log() { return log_; }
  const Recorder<nav_msgs::Path>& before() const { return before_; }
  nodelet::Loader& loader() { return loader_; }

 private:
  ros::NodeHandle handle_;
  ros::Publisher path_ = handle_.advertise<nav_msgs::Path>("slam/path", 10);
  tf2_ros::TransformBroadcaster tf_;
  Robot robot_;
  Recorder<msg::Tracks> tracks_{"tracks"};
  Recorder<msg::SceneGraph> graphs_{"scene_graph"};
  Recorder<diagnostic_msgs::DiagnosticArray> diagnostics_{"/diagnostics"};
  Recorder<rosgraph_msgs::Log> log_{"/rosout"};
  Recorder<nav_msgs::Path> before_{"trajectory_before"};
  nodelet::Loader loader_{false};
};

map::Map readMap(const fs::path& folder) { return map::loadMap(folder).map; }

std::set<std::uint64_t> listObjects(const map::Map& map) {
  std::set<std::uint64_t> ids;
  for (const auto& object : computeSceneGraph(map).objects) ids.insert(object.id.value);
  return ids;
}

/// Of the nearest primitive's middle to each box of the room, after the world has moved.
double findWorstBox(const map::Map& map, const Pose& T = Pose::Identity()) {
  double worst_m = 0.0;
  for (const Eigen::Vector3d& truth_m :
       {Eigen::Vector3d(1.5, 0.8, 0.35), Eigen::Vector3d(1.5, -0.8, 0.35)}) {
    double nearest_m = std::numeric_limits<double>::max();
    for (const auto& object : computeSceneGraph(map).objects) {
      nearest_m = std::min(nearest_m, (object.box.center() - T * truth_m).norm());
    }
    worst_m = std::max(worst_m, nearest_m);
  }
  return worst_m;
}

/// Share of the mesh that is at most 10 cm from the room's planes and boxes.
double computeShareOnSurfaces(const map::Map& map) {
  std::size_t near = 0;
  std::size_t all = 0;
  for (const auto& block : map.meshBlocks()) {
    for (const auto& vertex : block.mesh->vertices) {
      const Eigen::Vector3d p_m = vertex.cast<double>();
      double distance_m =
          std::min({std::abs(p_m.z()), std::abs(p_m.z() - 2.5), std::abs(std::abs(p_m.x()) - 3.0),
                    std::abs(std::abs(p_m.y()) - 3.0)});
      for (const Aabb& box : {makeAabb({1.2, 0.5, 0.0}, {1.8, 1.1, 0.7}),
                              makeAabb({1.2, -1.1, 0.0}, {1.8, -0.5, 0.7})}) {
        distance_m = std::min(distance_m, box.exteriorDistance(p_m));
      }
      near += distance_m < 0.1 ? 1 : 0;
      ++all;
    }
  }
  return all == 0 ? 0.0 : static_cast<double>(near) / static_cast<double>(all);
}

std::size_t countComponents(const PlaceGraph& graph) {
  std::map<PlaceId, PlaceId> root;
  for (const Place& place : graph.places) root[place.id] = place.id;
  const auto find = [&](PlaceId id) {
    while (root.at(id) != id) id = root.at(id);
    return id;
  };
  for (const PlaceEdge& edge : graph.edges) root[find(edge.a)] = find(edge.b);
  std::set<PlaceId> roots;
  for (const Place& place : graph.places) roots.insert(find(place.id));
  return roots.size();
}

std::string readBytes(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class Corrections : public ::testing::Test {
 protected:
  fs::path path(const std::string& name) const { return folder_.path() / name; }
  TemporaryFolder folder_;
};

TEST_F(Corrections, APathMendsAMapWhoseOdometryDrifts) {
  Chain chain(folder_.path(), path("map"));
  Chain::follow("world", "/slam/path");
  ASSERT_NO_FATAL_FAILURE(chain.start());
  ASSERT_NO_FATAL_FAILURE(chain.play(0, kNumFrames, 100.0, Pose::Identity()));
  ASSERT_NO_FATAL_FAILURE(chain.play(0, kNumFrames, 110.0, kDrift));
  Chain::save();
  const map::Map drifted = readMap(path("map"));
  const auto ids_before = listObjects(drifted);
  EXPECT_EQ(ids_before.size(), 4U);  // each box twice
  EXPECT_LT(computeShareOnSurfaces(drifted), 0.9);

  ASSERT_NO_FATAL_FAILURE(chain.sendPath(makeTruePath()));
  EXPECT_TRUE(chain.waitForLine(kApplied, "1"));
  EXPECT_TRUE(chain.waitForObjects(2));
  ASSERT_NO_FATAL_FAILURE(chain.play(0, kNumFrames, 120.0, kDrift));  // the odometry stays wrong
  Chain::save();
  const map::Map mended = readMap(path("map"));
  const auto ids_after = listObjects(mended);
  EXPECT_EQ(ids_after.size(), 2U);
  EXPECT_TRUE(
      std::includes(ids_before.begin(), ids_before.end(), ids_after.begin(), ids_after.end()));
  EXPECT_LT(findWorstBox(mended), 0.12);
  EXPECT_GT(computeShareOnSurfaces(mended), 0.97);
  EXPECT_FALSE(mended.places()->places.empty());
  // What is behind the boxes is not joined to the rest in a map of the truth, either.
  EXPECT_LE(countComponents(*mended.places()), 2U);
  EXPECT_EQ(mended.trajectory()->size(), 3U * kNumFrames);  // no frame was lost
  for (const auto& [ns, pose] : mended.trajectory()->poses()) {
    const int index = static_cast<int>(std::lround(Stamp{ns}.seconds() * 10.0)) % 100;
    EXPECT_LT((pose.translation() - computePose(index).translation()).norm(), 0.02) << ns;
  }
  EXPECT_EQ(chain.findDropped(), "");
  EXPECT_FALSE(chain.before().messages().empty());
  const auto occupancy = map::readOccupancy(path("map"), mapping::OccupancyConfig{});
  ASSERT_NE(occupancy, nullptr);
  EXPECT_EQ(occupancy->at({1.2, 0.0, 0.5}), mapping::Occupancy::kFree);
}

TEST_F(Corrections, WhatIsNoCorrectionIsNamedAndChangesNothing) {
  Chain chain(folder_.path(), path("map"));
  Chain::follow("world", "/slam/path");
  ASSERT_NO_FATAL_FAILURE(chain.start());
  ASSERT_NO_FATAL_FAILURE(chain.play(0, kNumFrames, 100.0, Pose::Identity()));
  ASSERT_NO_FATAL_FAILURE(chain.play(0, kNumFrames, 110.0, kDrift));
  Chain::save();
  const std::string mesh = readBytes(path("map") / "mesh.ply");
  const std::string poses = readBytes(path("map") / "trajectory.txt");
  const std::string primitives = readBytes(path("map") / "state" / "primitives.bin");

  nav_msgs::Path other_frame = makeTruePath();
  other_frame.header.frame_id = "elsewhere";
  nav_msgs::Path not_finite = makeTruePath();
  not_finite.poses[3].pose.position.x = std::numeric_limits<double>::quiet_NaN();
  nav_msgs::Path no_rotation = makeTruePath();
  no_rotation.poses[1].pose.orientation.w = no_rotation.poses[1].pose.orientation.x = 0.0;
  no_rotation.poses[1].pose.orientation.y = no_rotation.poses[1].pose.orientation.z = 0.0;
  nav_msgs::Path no_stamps = makeTruePath();
  for (auto& pose : no_stamps.poses) pose.header.stamp = ros::Time();
  nav_msgs::Path another_time = makeTruePath();
  for (auto& pose : another_time.poses) pose.header.stamp += ros::Duration(1000.0);
  nav_msgs::Path far = makeTruePath();
  for (auto& pose : far.poses) pose.pose.position.z += 1000.0;
  nav_msgs::Path empty = makeTruePath();
  empty.poses.clear();
  const std::vector<std::pair<nav_msgs::Path, std::string>> faults = {
      {other_frame, "elsewhere"}, {not_finite, "pose 4 of"},    {no_rotation, "pose 2 of"},
      {no_stamps, "has stamp 0"}, {another_time, "lie within"}, {far, "max_motion_m"},
      {empty, "has no pose"}};
  for (std::size_t i = 0; i < faults.size(); ++i) {
    ASSERT_NO_FATAL_FAILURE(chain.sendPath(faults[i].first));
    EXPECT_TRUE(chain.waitForLine(kRefused, std::to_string(i + 1) + "; last: /slam/path: "))
        << faults[i].second;
    EXPECT_TRUE(waitUntil([&] {
      return chain.findLine(kRefused).find(faults[i].second) != std::string::npos;
    })) << faults[i].second;
  }
  EXPECT_TRUE(waitForLog(chain.log(), {"/slam/path", "elsewhere", "expected world_frame"}));
  Chain::save();
  EXPECT_EQ(readBytes(path("map") / "mesh.ply"), mesh);
  EXPECT_EQ(readBytes(path("map") / "trajectory.txt"), poses);
  EXPECT_EQ(readBytes(path("map") / "state" / "primitives.bin"), primitives);
  EXPECT_TRUE(chain.waitForLine(kApplied, "0"));
}

TEST_F(Corrections, AJumpOfTheMapsFrameMovesAllOfIt) {
  const Pose jump = makePose(2.0, -1.0, 0.5);
  Chain chain(folder_.path(), path("map"));
  Chain::follow("odom", "");
  ros::param::set("/tracker/input/world_frame", "odom");
  ASSERT_NO_FATAL_FAILURE(chain.start());
  chain.sendOdometry(99.0, Pose::Identity());
  ASSERT_NO_FATAL_FAILURE(chain.play(0, kNumFrames, 100.0, Pose::Identity(), "odom"));
  Chain::save();
  const map::Map before = readMap(path("map"));
  EXPECT_LT(findWorstBox(before), 0.12);
  chain.sendOdometry(105.0, jump);
  ASSERT_NO_FATAL_FAILURE(chain.play(0, kNumFrames, 110.0, Pose::Identity(), "odom"));
  EXPECT_TRUE(chain.waitForLine(kApplied, "1"));
  Chain::save();
  const map::Map after = readMap(path("map"));
  EXPECT_EQ(listObjects(after), listObjects(before));
  EXPECT_LT(findWorstBox(after, jump), 0.12);
  EXPECT_EQ(countComponents(*after.places()), countComponents(*before.places()));
  EXPECT_GE(after.trajectory()->size(), 2U * kNumFrames - 2U);  // the first may come before tf
  for (const auto& [ns, pose] : after.trajectory()->poses()) {
    const int index = static_cast<int>(std::lround(Stamp{ns}.seconds() * 10.0)) % 100;
    EXPECT_TRUE(pose.isApprox(jump * computePose(index), 1e-6)) << ns;
  }
}

RgbdFramePtr makeFrame(int i) {
  auto frame = std::make_shared<RgbdFrame>(
      render(makeRoom(), {96, 72, 75.0, 75.0, 47.5, 35.5}, computePose(i)).frame);
  frame->stamp = Stamp::fromSeconds(100.0 + 0.1 * i);
  return frame;
}

/// What the background makes of frames that go through the corrections.
map::Map integrate(const std::string& name, const nodelets::CorrectionConfig& config) {
  ros::NodeHandle handle(name);
  ros_interface::StageReport report(name);
  nodelets::BackgroundStageOptions options;
  options.world_frame = "world";
  nodelets::BackgroundStage stage(handle, options, report);
  nodelets::CorrectionStage corrections(handle, {config, "world"}, report, {});
  for (int i = 0; i < kNumFrames; ++i) {
    const RgbdFramePtr frame = makeFrame(i);
    corrections.placeNew(frame, [&](const RgbdFramePtr& placed) {
      EXPECT_EQ(placed == frame, !corrections.isOn());  // the very same where they are off
      stage.addFrame(placed);
    });
  }
  EXPECT_TRUE(stage.flush(ros_interface::Patience::from(60.0, 60.0)).empty());
  return stage.makeMap();
}

TEST(WithoutACorrection, TheMapIsTheSameToTheBit) {
  nodelets::CorrectionConfig config;
  const map::Map off = integrate("off", config);
  config.odometry_frame = "world";
  config.path_topic = "/slam/path";
  const map::Map on = integrate("on", config);
  ASSERT_EQ(on.trajectory()->size(), static_cast<std::size_t>(kNumFrames));
  for (const auto& [ns, pose] : off.trajectory()->poses()) {
    EXPECT_EQ(on.trajectory()->poses().at(ns).matrix(), pose.matrix());
  }
  ASSERT_FALSE(off.meshBlocks().empty());
  ASSERT_EQ(on.meshBlocks().size(), off.meshBlocks().size());
  for (std::size_t i = 0; i < off.meshBlocks().size(); ++i) {
    EXPECT_EQ(on.meshBlocks()[i].mesh->vertices, off.meshBlocks()[i].mesh->vertices);
  }
  ASSERT_EQ(on.placeMemory()->blocks.size(), off.placeMemory()->blocks.size());
}

/// A floor of 5,000 blocks with 400 vertices each.
map::Map makeLargeMap() {
  std::vector<mapping::BlockMesh> blocks;
  for (int i = 0; i < 5000; ++i) {
    const mapping::GridIndex block(i % 100 - 50, i / 100 - 25, 0);
    Mesh mesh;
    for (std::uint32_t v = 0; v < 400; ++v) {
      mesh.vertices.push_back(block.cast<float>() * 0.4F +
                              0.02F * Eigen::Vector3f(static_cast<float>(v % 20) + 0.5F,
                                                      static_cast<float>(v / 20) + 0.5F, 0.5F));
      if (v % 20 == 19 || v / 20 == 19) continue;
      mesh.triangles.push_back({v, v + 1, v + 20});
      mesh.triangles.push_back({v + 1, v + 21, v + 20});
    }
    mesh.colors.resize(mesh.vertices.size());
    blocks.push_back({block, std::make_shared<const Mesh>(std::move(mesh))});
  }
  std::sort(blocks.begin(), blocks.end(),
            [](const auto& a, const auto& b) { return mapping::isBefore(a.block, b.block); });
  map::Map map("world");
  map.setMesh(0.05, std::move(blocks));
  return map;
}

TEST(CorrectionOfALargeMap, LosesNoFrameAndLeavesTheOldMapReadable) {
  ros::NodeHandle handle("large");
  ros_interface::StageReport report("large");
  nodelets::BackgroundStageOptions options;
  options.world_frame = "world";
  nodelets::BackgroundStage stage(handle, options, report);
  stage.restore(makeLargeMap());
  Trajectory own;
  const auto addFrame = [&](int i) {
    const RgbdFramePtr frame = makeFrame(i);
    own.add(frame->stamp, frame->T_world_camera);
    stage.addFrame(frame);
  };
  for (int i = 0; i < 20; ++i) addFrame(i);
  std::vector<trajectory::KeyframeMotion> motions;
  const auto keyframes = trajectory::selectKeyframes(own, "world", {0.05, 0.1});
  for (const auto& keyframe : keyframes.list()) {
    const double share = static_cast<double>(keyframe.id.value) / 20.0;
    motions.push_back({keyframe.id, makePose(share, 0.0, 0.02 * share)});
  }
  stage.correct(std::make_shared<const nodelets::MapCorrection>(
      nodelets::MapCorrection{{keyframes, trajectory::Correction(motions), 1.0, 0.02}, {}}));
  for (int i = 20; i < 40; ++i) addFrame(i);
  const map::Map meanwhile = stage.makeMap();  // the old one, or the new one; never half of it
  EXPECT_GE(meanwhile.meshBlocks().size(), 5000U);
  EXPECT_TRUE(stage.flush(ros_interface::Patience::from(60.0, 60.0)).empty());
  EXPECT_EQ(stage.makeMap().trajectory()->size(), 40U);
  EXPECT_EQ(report.processed(), 40U);
  EXPECT_EQ(report.dropped("integration queue full"), 0U);
  diagnostic_updater::DiagnosticStatusWrapper status;
  report.fill(status);
  for (const auto& line : status.values) {
    if (line.key.find("corrections") != 0) continue;
    std::cout << line.key << ": " << line.value << std::endl;
  }
}

TEST_F(Corrections, APathWithoutAnOdometryFrameIsRefusedAtTheStart) {
  Chain chain(folder_.path(), path("map"));
  Chain::follow("", "/slam/path");
  EXPECT_FALSE(load(chain.loader(), "mesh_fusion", "MeshFusion"));
  EXPECT_TRUE(waitForLog(chain.log(), {"corrections/odometry_frame is empty"}));
}

}  // namespace
}  // namespace tsg::test

int main(int argc, char** argv) { return tsg::test::runRosTests(argc, argv, "test_corrections"); }
