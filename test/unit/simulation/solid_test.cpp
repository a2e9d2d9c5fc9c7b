// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/solid.h"

#include <gtest/gtest.h>

#include "simulation_oracles.h"
#include "task_scene_graph/simulation/random.h"

namespace tsg::simulation {
namespace {

Eigen::Vector3d drawVector(Random& random, double low, double high) {
  Eigen::Vector3d v;
  for (int i = 0; i < 3; ++i) v[i] = random.uniform(low, high);
  return v;
}

Solid drawSolid(Random& random) {
  Solid solid;
  solid.shape = static_cast<Shape>(random.integer(3));
  solid.half_size_m = drawVector(random, 0.2, 1.0);
  solid.top_ratio = random.integer(3) * 0.5;
  const Eigen::Vector3d axis = drawVector(random, -1.0, 1.0);
  solid.T_world_solid.linear() =
      Eigen::AngleAxisd(random.uniform(0.0, 6.0), axis.normalized()).toRotationMatrix();
  solid.T_world_solid.translation() = drawVector(random, -1.0, 1.0);
  return solid;
}

UnitRay toUnitRay(const Solid& solid, const Eigen::Vector3d& origin, const Eigen::Vector3d& d) {
  const Pose T = solid.T_world_solid.inverse();
  return {(T * origin).cwiseQuotient(solid.half_size_m),
          (T.linear() * d).cwiseQuotient(solid.half_size_m)};
}

TEST(Solid, RaysHitWhereMarchingFindsTheSurface) {
  Random random(11);
  int hits = 0;
  for (int i = 0; i < 600; ++i) {
    const Solid solid = drawSolid(random);
    const Eigen::Vector3d origin = 4.0 * drawVector(random, -1.0, 1.0).normalized();
    const Eigen::Vector3d target =
        solid.T_world_solid.translation() + drawVector(random, -0.7, 0.7);
    const Eigen::Vector3d direction = (target - origin).normalized();
    if (isInside(solid, origin)) continue;
    const double t =
        intersectUnit(solid.shape, solid.top_ratio, toUnitRay(solid, origin, direction));
    const double expected = test::marchRay(solid, origin, direction, 1e-3);
    if (std::isinf(expected)) {
      // Marching may step over a grazing touch, never over 5 mm of material.
      EXPECT_TRUE(std::isinf(t) || !isInside(solid, origin + (t + 0.0025) * direction, 0.002));
      continue;
    }
    ++hits;
    ASSERT_NEAR(t, expected, 2e-3) << "shape " << static_cast<int>(solid.shape) << " case " << i;
  }
  EXPECT_GT(hits, 200);
}

TEST(Solid, ARayThatStartsInsideOrPointsAwayDoesNotEnter) {
  for (const Shape shape : {Shape::kBox, Shape::kEllipsoid, Shape::kFrustum}) {
    EXPECT_TRUE(std::isinf(intersectUnit(shape, 0.5, {{0, 0, 0}, {0.3, 0.2, 1.0}})));
    EXPECT_TRUE(std::isinf(intersectUnit(shape, 0.5, {{0, 0, 3}, {0.0, 0.0, 1.0}})));
    EXPECT_NEAR(intersectUnit(shape, 0.5, {{0, 0, 3}, {0.0, 0.0, -1.0}}), 2.0, 1e-12);
  }
}

TEST(Solid, BoundsHoldEverySurfacePointAndAreTight) {
  Random random(12);
  for (int i = 0; i < 100; ++i) {
    const Solid solid = drawSolid(random);
    const Aabb box = computeBounds(solid);
    Aabb seen;
    for (const Eigen::Vector3d& p : test::sampleSurface(solid, 60)) seen.extend(p);
    EXPECT_TRUE((seen.min().array() >= box.min().array() - 1e-9).all());
    EXPECT_TRUE((seen.max().array() <= box.max().array() + 1e-9).all());
    EXPECT_LT((seen.sizes() - box.sizes()).cwiseAbs().maxCoeff(), 0.02);
  }
}

TEST(Solid, NormalsPointOutwards) {
  Random random(13);
  for (int i = 0; i < 200; ++i) {
    const Solid solid = drawSolid(random);
    for (const Eigen::Vector3d& p : test::sampleSurface(solid, 5)) {
      const Eigen::Vector3d p_unit =
          (solid.T_world_solid.inverse() * p).cwiseQuotient(solid.half_size_m);
      const Eigen::Vector3d normal = solid.T_world_solid.linear() * computeNormal(solid, p_unit);
      EXPECT_NEAR(normal.norm(), 1.0, 1e-9);
      EXPECT_FALSE(isInside(solid, p + 1e-4 * normal));
    }
  }
}

}  // namespace
}  // namespace tsg::simulation
