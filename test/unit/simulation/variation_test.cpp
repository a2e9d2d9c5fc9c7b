// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/variation.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "task_scene_graph/simulation/renderer.h"

namespace tsg::simulation {
namespace {

std::set<Pattern> collectFloorPatterns(SurfaceSet set) {
  std::set<Pattern> patterns;
  for (int seed = 1; seed <= 12; ++seed) {
    Apartment apartment = buildFloorPlan({seed, 6});
    varySurfaces(apartment, set, static_cast<std::uint64_t>(seed));
    for (const Solid& solid : apartment.solids) {
      const double top_m = solid.T_world_solid.translation().z() + solid.half_size_m.z();
      if (std::abs(top_m) < 1e-6) patterns.insert(solid.material.pattern);
    }
  }
  return patterns;
}

TEST(Variation, TrainingAndHeldOutFloorsHaveNoPatternInCommon) {
  const auto training = collectFloorPatterns(SurfaceSet::kTraining);
  const auto held_out = collectFloorPatterns(SurfaceSet::kHeldOut);
  EXPECT_EQ(training.size(), 3U);
  EXPECT_EQ(held_out.size(), 2U);
  for (const Pattern pattern : held_out) EXPECT_EQ(training.count(pattern), 0U);
}

TEST(Variation, HeldOutWallsAreMoreColourfulThanAllTrainingWalls) {
  const auto saturationOf = [](const Color& c) {
    return (c.maxCoeff() - c.minCoeff()) / c.maxCoeff();
  };
  for (int seed = 1; seed <= 12; ++seed) {
    Apartment training = buildFloorPlan({seed, 6});
    Apartment held_out = training;
    varySurfaces(training, SurfaceSet::kTraining, static_cast<std::uint64_t>(seed));
    varySurfaces(held_out, SurfaceSet::kHeldOut, static_cast<std::uint64_t>(seed));
    for (const Room& room : training.rooms) EXPECT_LT(saturationOf(room.wall_color), 0.145F);
    for (const Room& room : held_out.rooms) EXPECT_GT(saturationOf(room.wall_color), 0.155F);
  }
}

TEST(Variation, ColoursOfThingsMoveALittleAndAllSolidsOfAThingAlike) {
  const Apartment before = buildApartment({5, 5});
  Apartment after = before;
  varySurfaces(after, SurfaceSet::kTraining, 5);
  int moved = 0;
  std::map<std::pair<std::uint16_t, std::vector<float>>, Color> seen;
  for (std::size_t i = 0; i < before.solids.size(); ++i) {
    if (before.solids[i].instance == 0) continue;
    const Color& old_color = before.solids[i].material.color;
    const Color& new_color = after.solids[i].material.color;
    EXPECT_LE(new_color.maxCoeff(), 1.0F);
    EXPECT_GE(new_color.minCoeff(), 0.0F);
    EXPECT_LT((new_color - old_color).cwiseAbs().maxCoeff(), 0.2F);
    moved += (new_color - old_color).norm() > 1e-3F ? 1 : 0;
    const std::vector<float> key(old_color.data(), old_color.data() + 3);
    const auto entry = seen.emplace(std::make_pair(before.solids[i].instance, key), new_color);
    EXPECT_TRUE(entry.first->second.isApprox(new_color));
  }
  EXPECT_GT(moved, 100);
}

TEST(Variation, RandomViewsShowThingsAndFollowFromTheSeed) {
  const Apartment apartment = buildApartment({5, 5});
  Random random(3);
  const std::vector<Pose> views = pickRandomViews(apartment, 8, random);
  ASSERT_EQ(views.size(), 8U);
  const Renderer renderer(apartment, 1);
  for (const Pose& T_world_camera : views) {
    EXPECT_GE(T_world_camera.translation().z(), 0.9);
    EXPECT_LE(T_world_camera.translation().z(), 1.7);
    const RenderedView view = renderer.render(makeDefaultCamera(128, 96), T_world_camera);
    EXPECT_GT(cv::countNonZero(view.labels), 50);
  }
  Random again(3);
  EXPECT_TRUE(pickRandomViews(apartment, 8, again).back().isApprox(views.back()));
}

}  // namespace
}  // namespace tsg::simulation
