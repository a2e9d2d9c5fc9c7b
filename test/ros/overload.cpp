// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "synthetic_robot.h"

namespace tsg::test {
namespace {

constexpr int kNumFrames = 20;

/// Voxels of one centimetre, and of three along every ray: depth integration cannot keep up.
TEST(Overload, DepthIntegrationDropsAndCountsFramesAndHoldsUpNothingElse) {
  Robot robot;
  Recorder<msg::Tracks> tracks("tracks");
  Recorder<diagnostic_msgs::DiagnosticArray> diagnostics("/diagnostics");
  nodelet::Loader loader(false);
  ASSERT_TRUE(load(loader, "tracker", "Tracker"));
  ASSERT_TRUE(load(loader, "mesh_fusion", "MeshFusion"));
  ASSERT_TRUE(robot.waitForSubscribers(1));
  ASSERT_TRUE(robot.waitForSegmentationSubscribers(1));
  ASSERT_TRUE(tracks.waitForPublisher());
  for (int i = 0; i < kNumFrames; ++i) {
    const RobotMessages messages = makeMessages(i);
    robot.publish(messages);
    ASSERT_TRUE(tracks.waitFor([&](const msg::Tracks& message) {
      return ros_interface::toStamp(message.header.stamp) == messages.stamp;
    })) << "no tracks for frame "
        << i;
  }
  const auto count = [&](const std::string& stage, const std::string& line) {
    const auto lines = findDiagnostics(diagnostics, stage);
    const auto found = lines.find(line);
    return found == lines.end() ? 0 : std::stoi(found->second);
  };
  EXPECT_TRUE(waitUntil([&] { return count("tracker", "processed") == kNumFrames; }));
  EXPECT_TRUE(waitUntil([&] {
    return count("mesh_fusion", "processed") +
               count("mesh_fusion", "dropped: integration queue full") ==
           kNumFrames;
  }));
  EXPECT_GT(count("mesh_fusion", "processed"), 0);
  EXPECT_GT(count("mesh_fusion", "dropped: integration queue full"), 0);
}

}  // namespace
}  // namespace tsg::test

int main(int argc, char** argv) { return tsg::test::runRosTests(argc, argv, "overload_test"); }
