// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/world_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "task_scene_graph/simulation/world.h"

namespace tsg::simulation {
namespace {

Solid makeSolid(Shape shape, double top_ratio = 1.0) {
  Solid solid;
  solid.shape = shape;
  solid.half_size_m = {0.5, 1.0, 1.5};
  solid.top_ratio = top_ratio;
  solid.T_world_solid = Eigen::Translation3d(2.0, -1.0, 3.0) *
                        Eigen::AngleAxisd(0.4, Eigen::Vector3d(1.0, 2.0, 3.0).normalized());
  return solid;
}

/// Positive where all triangles are counter-clockwise seen from outside.
double computeVolume(const Mesh& mesh) {
  double volume = 0.0;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[t[0]].cast<double>();
    const Eigen::Vector3d b = mesh.vertices[t[1]].cast<double>();
    volume += a.dot(b.cross(mesh.vertices[t[2]].cast<double>())) / 6.0;
  }
  return volume;
}

Mesh meshOf(const Solid& solid) {
  Apartment world;
  world.solids = {solid};
  return computeMesh(world);
}

TEST(WorldMesh, BodiesHaveTheirVolume) {
  const double product = 0.5 * 1.0 * 1.5;
  EXPECT_NEAR(computeVolume(meshOf(makeSolid(Shape::kBox))), 8.0 * product, 1e-4);
  const double circle = kPi * product;
  EXPECT_NEAR(computeVolume(meshOf(makeSolid(Shape::kFrustum))), 2.0 * circle, 0.03 * circle);
  EXPECT_NEAR(computeVolume(meshOf(makeSolid(Shape::kFrustum, 0.0))), 2.0 / 3.0 * circle,
              0.03 * circle);
  EXPECT_NEAR(computeVolume(meshOf(makeSolid(Shape::kEllipsoid))), 4.0 / 3.0 * circle,
              0.05 * circle);
}

TEST(WorldMesh, NoCornerLiesOutsideItsBody) {
  for (const Shape shape : {Shape::kBox, Shape::kEllipsoid, Shape::kFrustum}) {
    const Solid solid = makeSolid(shape, 0.6);
    for (const Eigen::Vector3f& p_m : meshOf(solid).vertices) {
      EXPECT_TRUE(isInside(solid, p_m.cast<double>(), -1e-4));
    }
  }
}

TEST(WorldMesh, CoversAWorldAsItsSolidsDo) {
  const Apartment world = buildWorld(WorldKind::kApartment, {});
  Aabb bounds;
  for (const Solid& solid : world.solids) bounds.extend(computeBounds(solid));
  const Aabb covered = computeMesh(world).computeBounds();
  EXPECT_LT((covered.min() - bounds.min()).norm(), 0.02);
  EXPECT_LT((covered.max() - bounds.max()).norm(), 0.02);
}

}  // namespace
}  // namespace tsg::simulation
