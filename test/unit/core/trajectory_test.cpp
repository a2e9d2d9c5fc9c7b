// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/trajectory.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace tsg {
namespace {

Pose makePose(double x, double yaw_rad = 0.0) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.translation().x() = x;
  return pose;
}

TEST(Trajectory, InterpolatesBetweenTheNearestPoses) {
  Trajectory trajectory;
  trajectory.add(Stamp::fromSeconds(2.0), makePose(4.0, 0.8));
  trajectory.add(Stamp::fromSeconds(1.0), makePose(2.0, 0.4));
  const auto pose = trajectory.interpolate(Stamp::fromSeconds(1.25), 1.0);
  ASSERT_TRUE(pose);
  EXPECT_TRUE(pose->isApprox(makePose(2.5, 0.5), 1e-9));
  EXPECT_TRUE(trajectory.interpolate(Stamp::fromSeconds(2.0), 0.0)->isApprox(makePose(4.0, 0.8)));
}

TEST(Trajectory, NothingIsInventedOutsideOrInGaps) {
  Trajectory trajectory;
  EXPECT_FALSE(trajectory.interpolate(Stamp::fromSeconds(1.0), 10.0));
  trajectory.add(Stamp::fromSeconds(1.0), makePose(0.0));
  trajectory.add(Stamp::fromSeconds(3.0), makePose(1.0));
  EXPECT_FALSE(trajectory.interpolate(Stamp::fromSeconds(0.9), 10.0));
  EXPECT_FALSE(trajectory.interpolate(Stamp::fromSeconds(3.1), 10.0));
  EXPECT_FALSE(trajectory.interpolate(Stamp::fromSeconds(2.0), 1.9));
  EXPECT_TRUE(trajectory.interpolate(Stamp::fromSeconds(2.0), 2.0));
  EXPECT_NEAR(trajectory.gapAt(Stamp::fromSeconds(2.0)), 2.0, 1e-9);
}

TEST(Trajectory, ForgettingKeepsTheLastPoseBefore) {
  Trajectory trajectory;
  for (int i = 0; i < 5; ++i) trajectory.add(Stamp::fromSeconds(i), makePose(i));
  trajectory.forgetBefore(Stamp::fromSeconds(2.5));
  EXPECT_EQ(trajectory.first(), Stamp::fromSeconds(2.0));
  EXPECT_EQ(trajectory.size(), 3U);
  trajectory.forgetBefore(Stamp::fromSeconds(0.0));
  EXPECT_EQ(trajectory.size(), 3U);
}

class TumTrajectory : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
    path_ = std::filesystem::temp_directory_path() / ("tsg_trajectory_" + name + ".txt");
  }
  void TearDown() override { std::filesystem::remove(path_); }
  Trajectory load(const std::string& text) {
    std::ofstream(path_) << text;
    return loadTumTrajectory(path_.string());
  }
  std::string errorOf(const std::string& text) {
    try {
      load(text);
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "";
  }
  void expectError(const std::string& text, const std::string& part) {
    const std::string error = errorOf(text);
    EXPECT_NE(error.find(part), std::string::npos) << error;
    EXPECT_NE(error.find(path_.string()), std::string::npos) << error;
  }

  std::filesystem::path path_;
};

TEST_F(TumTrajectory, CommentsBlankLinesAndCommasAreFine) {
  const Trajectory trajectory = load(
      "# timestamp tx ty tz qx qy qz qw\r\n\n1305031098.6659 1 2 3 0 0 0 1 # end\n"
      "1305031098.7659,2,2,3,0,0,0,2\r\n");
  ASSERT_EQ(trajectory.size(), 2U);
  EXPECT_EQ(trajectory.first().ns, 1305031098665900000);
  const auto pose = trajectory.interpolate(trajectory.first(), 0.0);
  EXPECT_TRUE(pose->translation().isApprox(Eigen::Vector3d(1, 2, 3)));
}

TEST_F(TumTrajectory, StampsKeepEveryNanosecond) {
  EXPECT_EQ(load("1700000000.123456789 0 0 0 0 0 0 1\n").first().ns, 1700000000123456789);
}

TEST_F(TumTrajectory, LinesThatAreNotANumberAreLeftOut) {
  EXPECT_EQ(load("1 0 0 0 0 0 0 1\n2 nan nan nan nan nan nan nan\n3 0 0 0 0 0 0 1\n").size(), 2U);
}

TEST_F(TumTrajectory, BrokenLinesAreNamed) {
  expectError("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 1\n", "line 2: 7 values");
  expectError("1 0 0 0 0 0 0 one\n", "line 1: 'one' is not a number");
  expectError("1 0 0 0 0 0 0 0\n", "line 1: the quaternion has no length");
  expectError("-1 0 0 0 0 0 0 1\n", "line 1: stamp -1");
  expectError("# nothing\n", "holds no pose");
}

TEST_F(TumTrajectory, OtherFormatsAreRecognised) {
  expectError("1 0 0 0 0 1 0 0 0 0 1 0\n", "KITTI");
  expectError("1403636579763555584 0 0 0 0 0 0 1\n", "nanoseconds");
}

TEST_F(TumTrajectory, AbsentFileIsNamed) {
  EXPECT_THROW(loadTumTrajectory("/nonexistent/poses.txt"), std::runtime_error);
}

}  // namespace
}  // namespace tsg
