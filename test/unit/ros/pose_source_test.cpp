// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/pose_source.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <filesystem>
#include <fstream>
#include <map>

#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/image_conversions.h"

namespace tsg::ros_interface {
namespace {

/// Stands for a message of any type, as rosbag and topic_tools hand them out.
template <typename Message>
struct AnyMessage {
  Message message;
  template <typename Wanted>
  boost::shared_ptr<Wanted> instantiate() const {
    if constexpr (std::is_same_v<Wanted, Message>) {
      return boost::make_shared<Wanted>(message);
    } else {
      return nullptr;
    }
  }
  std::string getDataType() const { return ros::message_traits::DataType<Message>::value(); }
};

class PoseSourceTest : public ::testing::Test {
 protected:
  void setTransform(const std::string& parent, const std::string& child, double seconds, double x,
                    bool is_static = false) {
    geometry_msgs::TransformStamped transform;
    transform.header.stamp.fromSec(seconds);
    transform.header.frame_id = parent;
    transform.child_frame_id = child;
    transform.transform.translation.x = x;
    transform.transform.rotation.w = 1.0;
    if (!is_static) history_.add(transform);
    tf_.setTransform(transform, "test", is_static);
  }
  static AnyMessage<nav_msgs::Odometry> makeOdometry(double seconds, double x,
                                                     const std::string& frame = "world",
                                                     const std::string& child = "camera") {
    AnyMessage<nav_msgs::Odometry> odometry;
    odometry.message.header.stamp.fromSec(seconds);
    odometry.message.header.frame_id = frame;
    odometry.message.child_frame_id = child;
    odometry.message.pose.pose.position.x = x;
    odometry.message.pose.pose.orientation.w = 1.0;
    return odometry;
  }
  static double xOf(const PoseSource::Answer& answer) {
    return answer.T_world_camera ? answer.T_world_camera->translation().x() : -999.0;
  }
  static void expectContains(const std::string& text, const std::vector<std::string>& parts) {
    for (const auto& part : parts) EXPECT_NE(text.find(part), std::string::npos) << text;
  }
  static InputConfig withTopic() {
    InputConfig config;
    config.pose_topic = "/odom";
    return config;
  }

  /// The camera's link every 0.1 s from 10 to 18 s, at x = seconds, but for a hole.
  void setTransformsWithHole(double hole_begin_s, double hole_end_s, double x_per_s = 1.0) {
    for (int i = 0; i <= 80; ++i) {
      const double seconds = 10.0 + 0.1 * i;
      if (seconds > hole_begin_s + 1e-3 && seconds < hole_end_s - 1e-3) continue;
      setTransform("world", "camera", seconds, x_per_s * seconds);
    }
  }
  PoseSource::Answer lookUp(double seconds, const InputConfig& config = {}) {
    return PoseSource(config, tf_, &history_).lookUp("camera", Stamp::fromSeconds(seconds));
  }

  tf2::BufferCore tf_;
  TransformHistory history_{12.0};
};

TEST_F(PoseSourceTest, HoleInTfThatTheCameraMovesAcrossIsNotInterpolatedOver) {
  setTransformsWithHole(12.0, 14.0);
  const auto answer = lookUp(13.0);
  EXPECT_FALSE(answer.T_world_camera);
  EXPECT_TRUE(answer.is_final);
  EXPECT_EQ(answer.reason, "hole in tf");
  expectContains(answer.why_not, {"stamp 13.000 s", "'camera'", "from 12.000 to 14.000 s",
                                  "2.000 s; usually about every 0.100 s", "input/max_tf_gap_s"});
  for (const double seconds : {11.95, 12.0, 14.0, 14.05}) {
    EXPECT_NEAR(xOf(lookUp(seconds)), seconds, 1e-9) << lookUp(seconds).why_not;
  }
}

TEST_F(PoseSourceTest, HoleInTfWithoutMotionDoesNoHarm) {
  setTransformsWithHole(12.0, 14.0, 0.0);
  EXPECT_NEAR(xOf(lookUp(13.0)), 0.0, 1e-9);
}

TEST_F(PoseSourceTest, HoleNoLongerThanTheLimitIsInterpolatedOver) {
  setTransformsWithHole(12.0, 12.4);
  EXPECT_NEAR(xOf(lookUp(12.2)), 12.2, 1e-9);
  InputConfig config;
  config.max_tf_gap_s = 0.35;
  EXPECT_EQ(lookUp(12.2, config).reason, "hole in tf");
}

TEST_F(PoseSourceTest, HoleInALinkBetweenMovingOnesIsFound) {
  setTransformsWithHole(12.0, 14.0);
  for (int i = 0; i <= 80; ++i) setTransform("map", "world", 10.0 + 0.1 * i, 0.1 * i);
  setTransform("camera", "lens", 0.0, 0.5, true);
  InputConfig config;
  config.world_frame = "map";
  const PoseSource poses(config, tf_, &history_);
  EXPECT_EQ(poses.lookUp("lens", Stamp::fromSeconds(13.05)).reason, "hole in tf");
  EXPECT_TRUE(poses.lookUp("lens", Stamp::fromSeconds(11.05)).T_world_camera);
  // The hole is no link between these two.
  config.world_frame = "camera";
  EXPECT_TRUE(
      PoseSource(config, tf_, &history_).lookUp("lens", Stamp::fromSeconds(13.05)).T_world_camera);
}

TEST_F(PoseSourceTest, LinkThatIsAlwaysSlowIsInterpolatedAndNamed) {
  for (int i = 0; i <= 8; ++i) setTransform("world", "camera", 10.0 + i, 10.0 + i);
  const PoseSource poses({}, tf_, &history_);
  EXPECT_EQ(poses.note(), "");
  EXPECT_NEAR(xOf(poses.lookUp("camera", Stamp::fromSeconds(13.5))), 13.5, 1e-9);
  expectContains(poses.note(), {"'camera'", "every 1.000 s"});
}

TEST_F(PoseSourceTest, HolesAreFoundWhereTransformsCameOutOfOrder) {
  for (const double seconds : {10.2, 10.0, 10.1, 12.2, 12.3, 10.0, 12.1}) {
    setTransform("world", "camera", seconds, seconds);
  }
  EXPECT_EQ(lookUp(11.0).reason, "hole in tf");
  EXPECT_NEAR(xOf(lookUp(12.15)), 12.15, 1e-9);
}

TEST_F(PoseSourceTest, TransformsOlderThanTheMemoryAreForgotten) {
  TransformHistory history(1.0);
  geometry_msgs::TransformStamped transform;
  transform.child_frame_id = "/camera";
  setTransform("world", "camera", 9.0, 0.0);
  for (const double seconds : {9.0, 10.0, 12.0}) {
    transform.header.stamp.fromSec(seconds);
    history.add(transform);
  }
  EXPECT_FALSE(history.findGap(tf_, "world", "camera", Stamp::fromSeconds(9.5)));
  transform.header.stamp.fromSec(11.5);
  history.add(transform);
  const auto gap = history.findGap(tf_, "world", "camera", Stamp::fromSeconds(11.7));
  ASSERT_TRUE(gap);
  EXPECT_EQ(gap->child, "camera");
  EXPECT_NEAR(gap->length_s, 0.5, 1e-9);
  history.clear();
  EXPECT_FALSE(history.findGap(tf_, "world", "camera", Stamp::fromSeconds(11.7)));
}

TEST_F(PoseSourceTest, TfIsInterpolated) {
  setTransform("world", "camera", 1.0, 1.0);
  setTransform("world", "camera", 2.0, 2.0);
  const PoseSource poses({}, tf_);
  EXPECT_NEAR(xOf(poses.lookUp("camera", Stamp::fromSeconds(1.5))), 1.5, 1e-9);
  EXPECT_NEAR(xOf(poses.lookUp("/camera", Stamp::fromSeconds(1.5))), 1.5, 1e-9);
}

TEST_F(PoseSourceTest, MissingFramesAndLinksAreNamed) {
  const PoseSource poses({}, tf_);
  expectContains(poses.lookUp("camera", Stamp::fromSeconds(1.0)).why_not,
                 {"no transform from 'camera' to 'world' at stamp 1.000 s", "/tf_static"});
  setTransform("world", "base_link", 1.0, 1.0);
  expectContains(
      poses.lookUp("camera", Stamp::fromSeconds(1.0)).why_not,
      {"tf knows no frame 'camera'", "base_link, world", "/tf_static", "--camera-frame"});
  setTransform("camera_link", "camera", 1.0, 1.0, true);
  expectContains(poses.lookUp("camera", Stamp::fromSeconds(1.0)).why_not,
                 {"the link between 'world' and 'camera_link' is missing"});
  InputConfig config;
  config.world_frame = "map";
  expectContains(PoseSource(config, tf_).lookUp("camera", Stamp::fromSeconds(1.0)).why_not,
                 {"tf knows no frame 'map'", "--world-frame"});
}

TEST_F(PoseSourceTest, StampsThatTfHasLeftBehindAreFinal) {
  setTransform("world", "camera", 10.0, 1.0);
  setTransform("world", "camera", 11.0, 2.0);
  const PoseSource poses({}, tf_);
  const auto early = poses.lookUp("camera", Stamp::fromSeconds(9.0));
  EXPECT_TRUE(early.is_final);
  const auto late = poses.lookUp("camera", Stamp::fromSeconds(12.0));
  EXPECT_FALSE(late.is_final);
  expectContains(late.why_not, {"its newest is of 11.000 s"});
}

TEST_F(PoseSourceTest, ImagesWithoutAFrameNeedTheSetting) {
  const PoseSource poses({}, tf_);
  expectContains(poses.lookUp("", Stamp::fromSeconds(1.0)).why_not,
                 {"frame_id is empty", "input/camera_frame"});
}

TEST_F(PoseSourceTest, OdometryOfTheCameraNeedsNoTf) {
  PoseSource poses(withTopic(), tf_);
  poses.add(makeOdometry(1.0, 1.0));
  poses.add(makeOdometry(1.2, 1.2));
  EXPECT_NEAR(xOf(poses.lookUp("camera", Stamp::fromSeconds(1.1))), 1.1, 1e-9);
  EXPECT_EQ(poses.note(), "");
}

TEST_F(PoseSourceTest, EveryTypeOfPoseIsTaken) {
  PoseSource poses(withTopic(), tf_);
  AnyMessage<geometry_msgs::PoseStamped> pose;
  pose.message.header.stamp.fromSec(1.0);
  pose.message.header.frame_id = "world";
  pose.message.pose.position.x = 3.0;
  pose.message.pose.orientation.w = 1.0;
  poses.add(pose);
  AnyMessage<geometry_msgs::PoseWithCovarianceStamped> with_covariance;
  with_covariance.message.header = pose.message.header;
  with_covariance.message.header.stamp.fromSec(2.0);
  with_covariance.message.pose.pose = pose.message.pose;
  poses.add(with_covariance);
  AnyMessage<geometry_msgs::TransformStamped> transform;
  transform.message.header = pose.message.header;
  transform.message.header.stamp.fromSec(3.0);
  transform.message.transform.translation.x = 4.0;
  transform.message.transform.rotation.w = 1.0;
  poses.add(transform);
  EXPECT_NEAR(xOf(poses.lookUp("camera", Stamp::fromSeconds(1.0))), 3.0, 1e-9);
  EXPECT_NEAR(xOf(poses.lookUp("camera", Stamp::fromSeconds(2.0))), 3.0, 1e-9);
  EXPECT_NEAR(xOf(poses.lookUp("camera", Stamp::fromSeconds(3.0))), 4.0, 1e-9);
  try {
    poses.add(AnyMessage<geometry_msgs::Pose>());
    FAIL() << "no error";
  } catch (const InputError& e) {
    expectContains(e.what(), {"/odom", "geometry_msgs/Pose", "nav_msgs/Odometry"});
  }
}

TEST_F(PoseSourceTest, LinkFromTheBodyToTheCameraIsTfs) {
  PoseSource poses(withTopic(), tf_);
  poses.add(makeOdometry(1.0, 1.0, "world", "base_link"));
  const auto missing = poses.lookUp("camera", Stamp::fromSeconds(1.0));
  EXPECT_FALSE(missing.T_world_camera);
  expectContains(missing.why_not, {"'base_link'", "/tf_static", "--pose-frame"});
  setTransform("base_link", "camera", 0.0, 0.25, true);
  EXPECT_NEAR(xOf(poses.lookUp("camera", Stamp::fromSeconds(1.0))), 1.25, 1e-9);
}

TEST_F(PoseSourceTest, PoseFrameSaysWhosePosesTheyAre) {
  InputConfig config = withTopic();
  config.pose_frame = "camera";
  PoseSource poses(config, tf_);
  poses.add(makeOdometry(1.0, 1.0, "world", "base_link"));
  EXPECT_NEAR(xOf(poses.lookUp("camera", Stamp::fromSeconds(1.0))), 1.0, 1e-9);
}

TEST_F(PoseSourceTest, PosesInAnotherFrameAreLinkedByTfOrNoted) {
  PoseSource poses(withTopic(), tf_);
  poses.add(makeOdometry(1.0, 1.0, "odom", "camera"));
  EXPECT_NEAR(xOf(poses.lookUp("camera", Stamp::fromSeconds(1.0))), 1.0, 1e-9);
  expectContains(poses.note(), {"'odom'", "'world'"});
  setTransform("world", "odom", 0.0, 5.0, true);
  EXPECT_NEAR(xOf(poses.lookUp("camera", Stamp::fromSeconds(1.0))), 6.0, 1e-9);
  EXPECT_EQ(poses.note(), "");
}

TEST_F(PoseSourceTest, GapsAndEndsAreSaid) {
  PoseSource poses(withTopic(), tf_);
  expectContains(poses.lookUp("camera", Stamp::fromSeconds(1.0)).why_not,
                 {"/odom", "none has come"});
  poses.add(makeOdometry(1.0, 1.0));
  poses.add(makeOdometry(3.0, 1.0));
  const auto gap = poses.lookUp("camera", Stamp::fromSeconds(2.0));
  EXPECT_TRUE(gap.is_final);
  expectContains(gap.why_not, {"2.000 s apart", "max_pose_gap_s"});
  const auto later = poses.lookUp("camera", Stamp::fromSeconds(4.0));
  EXPECT_FALSE(later.is_final);
  expectContains(later.why_not, {"go from 1.000 to 3.000 s"});
  poses.clear();
  expectContains(poses.lookUp("camera", Stamp::fromSeconds(2.0)).why_not, {"none has come"});
}

TEST_F(PoseSourceTest, AxesAndDirectionAreTurned) {
  InputConfig config = withTopic();
  config.camera_axes = CameraAxes::kBody;
  PoseSource body(config, tf_);
  body.add(makeOdometry(1.0, 1.0));
  const auto pose = body.lookUp("camera", Stamp::fromSeconds(1.0)).T_world_camera;
  ASSERT_TRUE(pose);
  EXPECT_TRUE((*pose * Eigen::Vector3d(0, 0, 2)).isApprox(Eigen::Vector3d(3, 0, 0)));
  EXPECT_TRUE((*pose * Eigen::Vector3d(0, 1, 0)).isApprox(Eigen::Vector3d(1, 0, -1)));
  EXPECT_NEAR(pose->linear().determinant(), 1.0, 1e-12);
  config.camera_axes = CameraAxes::kOpenGl;
  config.pose_direction = PoseDirection::kWorldToCamera;
  PoseSource inverse(config, tf_);
  inverse.add(makeOdometry(1.0, 1.0));
  const auto turned = inverse.lookUp("camera", Stamp::fromSeconds(1.0)).T_world_camera;
  EXPECT_TRUE((*turned * Eigen::Vector3d(0, 1, 2)).isApprox(Eigen::Vector3d(-1, -1, -2)));
}

TEST_F(PoseSourceTest, PosesThatAreNoneAreRefused) {
  PoseSource poses(withTopic(), tf_);
  auto odometry = makeOdometry(1.0, std::nan(""));
  EXPECT_THROW(poses.add(odometry), InputError);
  odometry = makeOdometry(0.0, 1.0);
  EXPECT_THROW(poses.add(odometry), InputError);
}

TEST_F(PoseSourceTest, LinksThatLeadBeyondAllBoundsTogetherAreRefused) {
  InputConfig config;
  const PoseSource poses(config, tf_);
  const std::map<double, std::string> expected{
      {1e308, "translation has a value that is not finite"},
      {6e8, "expected coordinates within 1e+09 m"}};
  for (const auto& [x_m, problem] : expected) {
    setTransform("world", "base", 10.0, x_m, true);
    setTransform("base", "camera", 10.0, x_m, true);
    const auto answer = poses.lookUp("camera", Stamp::fromSeconds(10.0));
    EXPECT_FALSE(answer.T_world_camera) << x_m;
    EXPECT_TRUE(answer.is_final);
    EXPECT_EQ(answer.reason, "bad pose");
    expectContains(answer.why_not, {"10.000 s", problem});
  }
}

TEST_F(PoseSourceTest, TrajectoryIsReadFromItsFile) {
  const auto path = std::filesystem::temp_directory_path() / "tsg_pose_source_test.txt";
  std::ofstream(path) << "1 1 0 0 0 0 0 1\n1.4 2 0 0 0 0 0 1\n";
  InputConfig config;
  config.trajectory = path.string();
  const PoseSource poses(config, tf_);
  EXPECT_NEAR(xOf(poses.lookUp("camera", Stamp::fromSeconds(1.2))), 1.5, 1e-9);
  const auto outside = poses.lookUp("camera", Stamp::fromSeconds(2.0));
  EXPECT_TRUE(outside.is_final);
  expectContains(outside.why_not, {path.string(), "go from 1.000 to 1.400 s"});
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace tsg::ros_interface
