// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/renderer.h"

#include <gtest/gtest.h>

#include <cstring>

#include "simulation_oracles.h"
#include "task_scene_graph/simulation/random.h"
#include "task_scene_graph/simulation/walk.h"

namespace tsg::simulation {
namespace {

const CameraModel kCamera{160, 120, 131.25, 131.25, 79.5, 59.5};

const Apartment& theApartment() {
  static const Apartment kApartment = buildApartment({1, 6});
  return kApartment;
}

const std::vector<WalkPose>& theWalk() {
  static const std::vector<WalkPose> kWalk = planWalk(theApartment(), WalkConfig{});
  return kWalk;
}

bool isEqual(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() &&
         std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

TEST(Renderer, DepthAndLabelsAreThoseOfMarchingThroughAllSolids) {
  const Renderer renderer(theApartment(), 2);
  Random random(21);
  int checked = 0;
  for (int i = 0; i < 12; ++i) {
    const Pose T =
        theWalk()[static_cast<std::size_t>(random.integer(static_cast<int>(theWalk().size())))]
            .T_world_camera;
    const RenderedView view = renderer.render(kCamera, T);
    for (int k = 0; k < 12; ++k) {
      const int u = random.integer(kCamera.width_px);
      const int v = random.integer(kCamera.height_px);
      const Eigen::Vector3d direction = T.linear() * kCamera.unproject(u, v, 1.0);
      double nearest = std::numeric_limits<double>::infinity();
      const Solid* hit = nullptr;
      for (const Solid& solid : theApartment().solids) {
        const double t = test::marchRay(solid, T.translation(), direction, 2e-3);
        if (t < nearest) {
          nearest = t;
          hit = &solid;
        }
      }
      ASSERT_NE(hit, nullptr);
      const auto depth = static_cast<double>(view.depth_m.at<float>(v, u));
      // Marching may step over less than 2 mm of material at a silhouette; then the depth is less.
      if (depth < nearest - 1e-4) continue;
      ++checked;
      EXPECT_NEAR(depth, nearest, 1e-4);
      EXPECT_EQ(view.labels.at<std::uint16_t>(v, u), hit->instance);
      EXPECT_EQ(view.parts.at<std::uint16_t>(v, u), hit->part);
    }
  }
  EXPECT_GE(checked, 140);
}

TEST(Renderer, InAClosedApartmentEveryRayHitsAndRoomsAreCounted) {
  const Renderer renderer(theApartment(), 2);
  for (std::size_t i = 0; i < theWalk().size(); i += 97) {
    const RenderedView view = renderer.render(kCamera, theWalk()[i].T_world_camera);
    double low = 0.0;
    cv::minMaxLoc(view.depth_m, &low, nullptr);
    EXPECT_GT(low, 0.05);
    int sum = 0;
    for (const int pixels : view.room_pixels) sum += pixels;
    EXPECT_EQ(sum, kCamera.width_px * kCamera.height_px);
    EXPECT_LT(view.room_pixels[0], sum / 4);
  }
}

TEST(Renderer, ImagesDoNotDependOnTheNumberOfThreads) {
  const Pose T = theWalk()[theWalk().size() / 3].T_world_camera;
  const RenderedView one = Renderer(theApartment(), 1).render(kCamera, T);
  const RenderedView four = Renderer(theApartment(), 4).render(kCamera, T);
  EXPECT_TRUE(isEqual(one.color, four.color));
  EXPECT_TRUE(isEqual(one.depth_m, four.depth_m));
  EXPECT_TRUE(isEqual(one.labels, four.labels));
  EXPECT_TRUE(isEqual(one.parts, four.parts));
  EXPECT_EQ(one.room_pixels, four.room_pixels);
}

TEST(Renderer, ViewsShowManyThingsInManyColors) {
  const Renderer renderer(theApartment(), 2);
  std::vector<bool> seen(theApartment().instances.size() + 1, false);
  for (std::size_t i = 0; i < theWalk().size(); i += 12) {
    const RenderedView view = renderer.render(kCamera, theWalk()[i].T_world_camera);
    for (int v = 0; v < kCamera.height_px; ++v) {
      for (int u = 0; u < kCamera.width_px; ++u) seen[view.labels.at<std::uint16_t>(v, u)] = true;
    }
  }
  const auto count = static_cast<double>(std::count(seen.begin(), seen.end(), true));
  EXPECT_GT(count, 0.8 * static_cast<double>(seen.size()));
}

TEST(Renderer, RefusesAnInvalidCamera) {
  CameraModel camera = kCamera;
  camera.fx_px = 0.0;
  EXPECT_THROW(Renderer(theApartment(), 1).render(camera, Pose::Identity()), std::invalid_argument);
}

}  // namespace
}  // namespace tsg::simulation
