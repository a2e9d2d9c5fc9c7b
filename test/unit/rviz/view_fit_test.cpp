// SPDX-License-Identifier: BSD-3-Clause
#include "rviz/view_fit.h"

#include <gtest/gtest.h>

#include <random>

namespace tsg::rviz_plugin {
namespace {

/// Where a point is in the picture of rviz's orbit camera: -1 and 1 are the edges.
Eigen::Vector2d project(const Eigen::Vector3d& p, const OrbitView& view, double yaw, double pitch,
                        double tan_up, double aspect) {
  const Eigen::Vector3d from(std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch),
                             std::sin(pitch));
  const Eigen::Vector3d camera = view.focal_point_m + view.distance_m * from;
  const Eigen::Vector3d right = Eigen::Vector3d::UnitZ().cross(from).normalized();
  const Eigen::Vector3d up = from.cross(right);
  const Eigen::Vector3d d = p - camera;
  const double depth = -d.dot(from);
  EXPECT_GT(depth, 0.0);
  return {d.dot(right) / depth / tan_up / aspect, d.dot(up) / depth / tan_up};
}

TEST(ViewFit, AWholeBoxIsSeenAndReachesToTwoOppositeEdges) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> anywhere(-20.0, 20.0);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  for (int round = 0; round < 200; ++round) {
    Eigen::AlignedBox3d box;
    for (int i = 0; i < 2; ++i) {
      box.extend(Eigen::Vector3d(anywhere(random), anywhere(random), 0.3 * anywhere(random)));
    }
    const double yaw = 6.28 * part(random);
    const double pitch = 0.1 + 1.4 * part(random);
    const double tan_up = std::tan(0.2 + 0.4 * part(random));
    const double aspect = 0.5 + 1.5 * part(random);
    const double margin = 1.0 + 0.2 * part(random);
    const OrbitView view = fitOrbitView(box, yaw, pitch, tan_up, aspect, margin);
    Eigen::AlignedBox2d seen;
    for (int i = 0; i < 8; ++i) {
      const auto corner = static_cast<Eigen::AlignedBox3d::CornerType>(i);
      seen.extend(project(box.corner(corner), view, yaw, pitch, tan_up, aspect));
    }
    EXPECT_LE(seen.max().maxCoeff(), 1.0 / margin + 1e-9);
    EXPECT_GE(seen.min().minCoeff(), -1.0 / margin - 1e-9);
    EXPECT_NEAR(seen.sizes().maxCoeff(), 2.0 / margin, 1e-9);
  }
}

TEST(ViewFit, FromAboveTheTighterSideDecides) {
  const Eigen::AlignedBox3d box(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(10, 5, 3));
  EXPECT_DOUBLE_EQ(fitScale(box, 0.0, 800, 600, 1.0), 80.0);
  EXPECT_NEAR(fitScale(box, 0.5 * M_PI, 800, 600, 1.0), 60.0, 1e-9);
  EXPECT_DOUBLE_EQ(fitScale(box, 0.0, 800, 600, 2.0), 40.0);
}

}  // namespace
}  // namespace tsg::rviz_plugin
