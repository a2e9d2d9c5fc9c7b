// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/stage_report.h"

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <gtest/gtest.h>

#include <string>

namespace tsg::ros_interface {
namespace {

using diagnostic_msgs::DiagnosticStatus;

DiagnosticStatus read(StageReport& report) {
  diagnostic_updater::DiagnosticStatusWrapper status;
  report.fill(status);
  return status;
}

TEST(StageReport, IsAnErrorWithTheFirstCauseWhileEverythingIsDropped) {
  StageReport report("tracker");
  EXPECT_EQ(read(report).level, DiagnosticStatus::OK);
  report.countInput();
  report.countDropped("no pose", "no transform from 'camera' to 'map'");
  report.countDropped("queue full");
  for (int i = 0; i < 3; ++i) {  // also when nothing new has come since
    const DiagnosticStatus status = read(report);
    EXPECT_EQ(status.level, DiagnosticStatus::ERROR);
    EXPECT_NE(status.message.find("2 dropped, first: no transform from 'camera' to 'map'"),
              std::string::npos)
        << status.message;
  }
  report.countProcessed(1.0);
  EXPECT_EQ(read(report).level, DiagnosticStatus::OK);
}

TEST(StageReport, SomeDropsAreAWarning) {
  StageReport report("segmenter");
  report.countProcessed(1.0);
  report.countDropped("a newer image came");
  const DiagnosticStatus status = read(report);
  EXPECT_EQ(status.level, DiagnosticStatus::WARN);
  EXPECT_EQ(status.message, "a newer image came");
  EXPECT_EQ(read(report).level, DiagnosticStatus::OK);
}

}  // namespace
}  // namespace tsg::ros_interface
