// SPDX-License-Identifier: BSD-3-Clause
// A robot that has only odometry, which drifts: places seen again correct the map.
#include <gtest/gtest.h>
#include <nav_msgs/Path.h>
#include <std_srvs/Trigger.h>
#include <task_scene_graph/Flush.h>
#include <tf2_msgs/TFMessage.h>
#include <visualization_msgs/MarkerArray.h>

#include <iostream>
#include <optional>

#include "drifting_walk.h"
#include "loop_stage.h"
#include "support.h"
#include "synthetic_robot.h"
#include "task_scene_graph/simulation/depth_noise.h"
#include "task_scene_graph/simulation/renderer.h"
#include "task_scene_graph/simulation/segment_simulator.h"
#include "task_scene_graph/simulation/variation.h"

namespace tsg::test {
namespace {

constexpr const char* kCamera = "camera_color_optical_frame";

/// Two laps through three rooms, keyframes only; seen as a camera and a segmenter would.
class Walk {
 public:
  Walk() : indices_(selectPoses(walk_, {})) {}

  std::size_t size() const { return indices_.size(); }
  const Pose& odometry(std::size_t k) const { return walk_.odometry[indices_[k]].T_world_camera; }
  Stamp stamp(std::size_t k) const { return shift(walk_.odometry[indices_[k]].stamp); }
  RgbdFramePtr frame(std::size_t k) const {
    const auto view = render(k);
    const auto frame = std::make_shared<RgbdFrame>();
    frame->stamp = stamp(k);
    frame->camera = camera_;
    frame->T_world_camera = odometry(k);
    frame->color.image = view.color;
    frame->depth.image = simulation::toMillimetres(view.depth_m, 0.3, 6.0);
    return frame;
  }
  SegmentationPtr segmentation(std::size_t k) const {
    return std::make_shared<Segmentation>(
        segmenter_.segment(render(k), stamp(k), static_cast<std::int64_t>(indices_[k])));
  }
  RobotMessages messages(std::size_t k) const {
    const RgbdFramePtr frame = this->frame(k);
    RobotMessages messages;
    messages.stamp = frame->stamp;
    messages.color =
        ros_interface::toImageMessage(frame->color.image, "rgb8", frame->stamp, kCamera);
    messages.depth =
        ros_interface::toImageMessage(frame->depth.image, "16UC1", frame->stamp, kCamera);
    messages.info = boost::make_shared<sensor_msgs::CameraInfo>();
    messages.info->header = messages.color->header;
    messages.info->width = static_cast<std::uint32_t>(camera_.width_px);
    messages.info->height = static_cast<std::uint32_t>(camera_.height_px);
    messages.info->K = {camera_.fx_px, 0, camera_.cx_px, 0, camera_.fy_px, camera_.cy_px, 0, 0, 1};
    messages.segmentation = ros_interface::toMessage(*segmentation(k), kCamera);
    messages.transform.header = messages.color->header;
    messages.transform.header.frame_id = "odom";
    messages.transform.child_frame_id = kCamera;
    messages.transform.transform = ros_interface::toTransform(odometry(k));
    return messages;
  }
  /// Root mean square distance from the truth of poses by stamp.
  double computeError(const Trajectory& poses) const {
    double squares = 0.0;
    std::size_t count = 0;
    for (const auto& pose : walk_.truth) {
      const auto found = poses.poses().find(shift(pose.stamp).ns);
      if (found == poses.poses().end()) continue;
      squares += (found->second.translation() - pose.T_world_camera.translation()).squaredNorm();
      ++count;
    }
    return std::sqrt(squares / static_cast<double>(count));
  }

 private:
  /// Walks begin at 0, which is no stamp.
  static Stamp shift(Stamp stamp) { return {stamp.ns + 100000000000}; }
  simulation::RenderedView render(std::size_t k) const {
    return renderer_.render(camera_, walk_.truth[indices_[k]].T_world_camera);
  }

  DriftingWalk walk_ = makeDriftingWalk(3, 3, 2, 0.03);
  CameraModel camera_ = simulation::makeDefaultCamera(128, 96);
  simulation::Renderer renderer_{walk_.apartment, 2};
  simulation::SegmentSimulator segmenter_{walk_.apartment, {}};
  std::vector<std::size_t> indices_;
};

Trajectory toTrajectory(const nav_msgs::Path& path) {
  Trajectory trajectory;
  for (const auto& pose : path.poses) {
    trajectory.add(ros_interface::toStamp(pose.header.stamp), ros_interface::toPose(pose.pose));
  }
  return trajectory;
}

class Chain {
 public:
  Chain() {
    ros::param::set("/mesh_fusion/corrections/odometry_frame", "odom");
    ros::param::set("/mesh_fusion/corrections/path_topic", "");
    ros::param::set("/mesh_fusion/corrections/close_loops", true);
  }
  void start() {
    ASSERT_TRUE(load(loader_, "tracker", "Tracker"));
    ASSERT_TRUE(load(loader_, "mesh_fusion", "MeshFusion"));
    ASSERT_TRUE(robot_.waitForSubscribers(1));
    ASSERT_TRUE(robot_.waitForSegmentationSubscribers(1));
    ASSERT_TRUE(tracks_.waitForPublisher());
  }
  void play(const Walk& walk, std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const RobotMessages messages = walk.messages(k);
      robot_.publish(messages);
      ASSERT_TRUE(waitForTracks(tracks_, messages)) << k;
      // Faster than it can follow, keyframes are passed over: not what is tested here.
      ASSERT_TRUE(waitUntil([&] { return numWaiting() < 30; })) << k;
    }
  }
  /// All that was seen is in the map, with all loop closures.
  void flush() {
    // The loop closures' share of the time that flushing takes is for those that come last.
    ASSERT_TRUE(waitUntil([&] { return numWaiting() == 0; }, 300.0));
    msg::Flush call;
    call.request.mode = msg::FlushRequest::END;
    call.request.timeout_s = 240.0F;
    call.request.quiet_s = 60.0F;
    ASSERT_TRUE(ros::service::call("/mesh_fusion/flush", call));
  }
  std::string findLine(const std::string& key) const {
    const auto lines = findDiagnostics(diagnostics_, "mesh_fusion");
    const auto line = lines.find(key);
    return line == lines.end() ? "" : line->second;
  }
  bool waitForLine(const std::string& key, const std::string& value) {
    return waitUntil([&] { return findLine(key) == value; });
  }
  /// The newest of those that were sent since.
  Trajectory waitForTrajectory() {
    const std::size_t count = trajectories_.messages().size();
    EXPECT_TRUE(waitUntil([&] { return trajectories_.messages().size() > count + 1; }));
    return toTrajectory(*trajectories_.messages().back());
  }
  std::optional<Pose> findOdometry() const {
    std::optional<Pose> newest;
    for (const auto& message : tf_.messages()) {
      for (const auto& transform : message->transforms) {
        if (transform.header.frame_id != "map" || transform.child_frame_id != "odom") continue;
        newest = ros_interface::toPose(transform.transform);
      }
    }
    return newest;
  }
  const Recorder<visualization_msgs::MarkerArray>& loops() const { return loops_; }
  Recorder<rosgraph_msgs::Log>& log() { return log_; }
  nodelet::Loader& loader() { return loader_; }

 private:
  int numWaiting() const {
    const std::string line = findLine("loop closures: keyframes that wait");
    return line.empty() ? 0 : std::stoi(line);
  }

  Robot robot_;
  Recorder<msg::Tracks> tracks_{"tracks"};
  Recorder<diagnostic_msgs::DiagnosticArray> diagnostics_{"/diagnostics"};
  Recorder<rosgraph_msgs::Log> log_{"/rosout"};
  Recorder<nav_msgs::Path> trajectories_{"trajectory"};
  Recorder<visualization_msgs::MarkerArray> loops_{"loop_closures"};
  Recorder<tf2_msgs::TFMessage> tf_{"/tf"};
  nodelet::Loader loader_{false};
};

TEST(LoopClosures, CorrectTheMapAndTellTfWhereTheOdometryIs) {
  const Walk walk;
  Chain chain;
  ASSERT_NO_FATAL_FAILURE(chain.start());
  Trajectory odometry;
  for (std::size_t k = 0; k < walk.size(); ++k) odometry.add(walk.stamp(k), walk.odometry(k));
  ASSERT_NO_FATAL_FAILURE(chain.play(walk, 0, walk.size()));
  ASSERT_NO_FATAL_FAILURE(chain.flush());
  const Trajectory corrected = chain.waitForTrajectory();
  EXPECT_GT(corrected.size(), walk.size() / 2);
  const double before_m = walk.computeError(odometry);
  const double after_m = walk.computeError(corrected);
  std::cout << "trajectory: " << before_m << " m before, " << after_m << " m after; "
            << chain.findLine("corrections: applied") << " corrections" << std::endl;
  EXPECT_GT(before_m, 0.15);
  EXPECT_LT(after_m, 0.5 * before_m);
  EXPECT_TRUE(chain.waitForLine("corrections: refused", "0"));
  EXPECT_EQ(chain.findLine("loop closures: keyframes"), std::to_string(walk.size()));
  EXPECT_EQ(chain.findLine("loop closures: keyframes passed over"), "0");

  const auto T_map_odom = chain.findOdometry();
  ASSERT_TRUE(T_map_odom);
  EXPECT_GT(T_map_odom->translation().norm(), 0.05);
  ASSERT_FALSE(chain.loops().messages().empty());
  EXPECT_GT(chain.loops().messages().back()->markers[0].points.size(), 4U);
}

TEST(LoopClosures, AreNotSentToTfWhereSomebodyElseSaysWhereTheOdometryIs) {
  const Walk walk;
  Chain chain;
  ASSERT_NO_FATAL_FAILURE(chain.start());
  tf2_ros::TransformBroadcaster tf;
  geometry_msgs::TransformStamped transform;
  transform.header.stamp = ros_interface::toRosTime(walk.stamp(0));
  transform.header.frame_id = "map";
  transform.child_frame_id = "odom";
  transform.transform.rotation.w = 1.0;
  tf.sendTransform(transform);
  ASSERT_TRUE(waitUntil([&] { return chain.findOdometry().has_value(); }));
  ASSERT_NO_FATAL_FAILURE(chain.play(walk, 0, 3));
  EXPECT_TRUE(waitForLog(chain.log(), {"tf links 'map' to 'odom' already", "close_loops"}));
}

TEST(LoopClosures, AreRefusedAtTheStartWhereTheyCannotBe) {
  Chain chain;
  ros::param::set("/mesh_fusion/corrections/path_topic", "/slam/path");
  EXPECT_FALSE(load(chain.loader(), "mesh_fusion", "MeshFusion"));
  EXPECT_TRUE(waitForLog(chain.log(), {"close_loops is true and", "'/slam/path'"}));
  ros::param::set("/mesh_fusion/corrections/path_topic", "");
  ros::param::set("/mesh_fusion/corrections/odometry_frame", "");
  EXPECT_FALSE(load(chain.loader(), "mesh_fusion", "MeshFusion"));
  EXPECT_TRUE(waitForLog(chain.log(), {"close_loops is true", "odometry_frame is empty"}));
}

class LoopStages : public testing::Test {
 protected:
  std::string findLine(const std::string& key) {
    diagnostic_updater::DiagnosticStatusWrapper status;
    report_.fill(status);
    for (const auto& line : status.values) {
      if (line.key == "loop closures: " + key) return line.value;
    }
    return "";
  }
  void add(std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) stage_.addFrame(walk_.frame(k), nullptr);
  }
  bool finish() { return stage_.finish(ros_interface::Patience::from(60.0, 30.0)); }

  Walk walk_;
  ros_interface::StageReport report_{"loops"};
  nodelets::LoopStage stage_{{{}, "odom", 5.0}, report_, [](const nodelets::LoopResult&) {}};
};

TEST_F(LoopStages, BeginAnewAndEndWhereTheyAreTold) {
  add(0, 10);
  ASSERT_TRUE(finish());
  EXPECT_EQ(findLine("keyframes"), "10");
  stage_.end();
  add(10, 15);
  ASSERT_TRUE(finish());
  EXPECT_EQ(findLine("keyframes"), "10");
  stage_.restart();
  add(0, 4);
  ASSERT_TRUE(finish());
  EXPECT_EQ(findLine("keyframes"), "4");
}

TEST_F(LoopStages, PassOverWhatTheyCannotFollowAndWhatIsLate) {
  const RgbdFramePtr first = walk_.frame(0);
  for (std::size_t k = 0; k < 200; ++k) {
    const auto frame = std::make_shared<RgbdFrame>(*first);
    frame->stamp.ns += static_cast<std::int64_t>(k) * 1000000000;
    frame->T_world_camera.translation().x() += 0.6 * static_cast<double>(k);
    stage_.addFrame(frame, nullptr);
  }
  stage_.addFrame(first, nullptr);
  ASSERT_TRUE(finish());
  stage_.check();
  const int num_seen = std::stoi(findLine("keyframes"));
  EXPECT_EQ(num_seen + std::stoi(findLine("keyframes passed over")), 200);
  EXPECT_GE(num_seen, 50);
}

}  // namespace
}  // namespace tsg::test

int main(int argc, char** argv) { return tsg::test::runRosTests(argc, argv, "test_loop_closures"); }
