// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/loop_markers.h"

#include <gtest/gtest.h>

namespace tsg::ros_interface {
namespace {

using visualization_msgs::Marker;

LoopMarkerLine makeLine(double x_m, bool is_accepted, double residual_m) {
  return {{x_m, 0.0, 1.0}, {x_m, 2.0, 1.0}, is_accepted, residual_m};
}

TEST(LoopMarkers, TellAcceptedFromRejectedAndShowResiduals) {
  const auto array = makeLoopMarkers(
      {makeLine(1.0, true, 0.0), makeLine(2.0, false, 0.0), makeLine(3.0, true, 5.0)}, "map");
  ASSERT_EQ(array.markers.size(), 2U);
  const Marker& accepted = array.markers[0];
  EXPECT_EQ(accepted.ns, "accepted");
  EXPECT_EQ(accepted.header.frame_id, "map");
  EXPECT_EQ(accepted.action, Marker::ADD);
  ASSERT_EQ(accepted.points.size(), 4U);
  ASSERT_EQ(accepted.colors.size(), 4U);
  EXPECT_EQ(accepted.points[2].x, 3.0);
  EXPECT_EQ(accepted.points[3].y, 2.0);
  EXPECT_LT(accepted.colors[0].r, accepted.colors[2].r);
  EXPECT_LE(accepted.colors[2].r, 1.0F);
  EXPECT_GT(accepted.colors[0].g, accepted.colors[0].r);
  const Marker& rejected = array.markers[1];
  EXPECT_EQ(rejected.ns, "rejected");
  ASSERT_EQ(rejected.points.size(), 2U);
  EXPECT_EQ(rejected.points[0].x, 2.0);
  EXPECT_GT(rejected.colors[0].r, rejected.colors[0].g);
}

TEST(LoopMarkers, OfNoLoopsClearThePicture) {
  const auto array = makeLoopMarkers({}, "map");
  ASSERT_EQ(array.markers.size(), 2U);
  for (const Marker& marker : array.markers) EXPECT_EQ(marker.action, Marker::DELETE);
}

}  // namespace
}  // namespace tsg::ros_interface
