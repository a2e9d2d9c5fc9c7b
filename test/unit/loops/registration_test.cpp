// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/loops/registration.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>

#include "task_scene_graph/config/config.h"

namespace tsg::loops {
namespace {

/// Points on a rectangle spanned by two edges, with noise.
void addRectangle(const Eigen::Vector3f& corner, const Eigen::Vector3f& u, const Eigen::Vector3f& v,
                  std::mt19937& engine, Points& points) {
  std::uniform_real_distribution<float> share(0.0F, 1.0F);
  std::normal_distribution<float> noise(0.0F, 0.005F);
  const auto count = static_cast<int>(400.0F * u.cross(v).norm());
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3f off(noise(engine), noise(engine), noise(engine));
    points.push_back(corner + share(engine) * u + share(engine) * v + off);
  }
}

void addBox(const Eigen::Vector3f& min, const Eigen::Vector3f& size, std::mt19937& engine,
            Points& points) {
  const Eigen::Vector3f x(size.x(), 0.0F, 0.0F);
  const Eigen::Vector3f y(0.0F, size.y(), 0.0F);
  const Eigen::Vector3f z(0.0F, 0.0F, size.z());
  addRectangle(min, x, y, engine, points);
  addRectangle(min + z, x, y, engine, points);
  addRectangle(min, x, z, engine, points);
  addRectangle(min + y, x, z, engine, points);
  addRectangle(min, y, z, engine, points);
  addRectangle(min + x, y, z, engine, points);
}

/// A room of 4 m x 3 m with a table and two cupboards around the origin; others by `variant`.
Points makeRoom(std::uint32_t seed, int variant = 0) {
  std::mt19937 engine(seed);
  Points points;
  const float shift = 0.7F * static_cast<float>(variant);
  addBox({-2.0F, -1.5F, -1.4F}, {4.0F + shift, 3.0F - 0.5F * shift, 2.5F}, engine, points);
  addBox({-1.9F + 2.0F * shift, -1.4F, -1.4F}, {0.6F, 1.2F, 1.8F}, engine, points);
  addBox({0.4F - shift, 0.3F - shift, -1.4F}, {1.2F, 0.7F, 0.75F}, engine, points);
  addBox({1.2F, -1.4F + shift, -1.4F}, {0.5F, 0.5F, 1.0F}, engine, points);
  return points;
}

Points makeCorridor(std::uint32_t seed) {
  std::mt19937 engine(seed);
  Points points;
  const Eigen::Vector3f x(8.0F, 0.0F, 0.0F);
  addRectangle({-4.0F, -0.7F, -1.4F}, x, {0.0F, 1.4F, 0.0F}, engine, points);
  addRectangle({-4.0F, -0.7F, -1.4F}, x, {0.0F, 0.0F, 2.5F}, engine, points);
  addRectangle({-4.0F, 0.7F, -1.4F}, x, {0.0F, 0.0F, 2.5F}, engine, points);
  return points;
}

Pose makeMotion(double x_m, double y_m, double yaw_rad) {
  Pose T = Pose::Identity();
  T.translation() = Eigen::Vector3d(x_m, y_m, 0.05);
  T.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).matrix();
  return T;
}

/// The room as seen from elsewhere in it: T_target_source is the motion.
RegisteredCloud seenFrom(const Pose& T_target_source, const Points& points) {
  return {transform(T_target_source.inverse(), points), {}};
}

void expectNear(const Pose& a, const Pose& b, double tolerance_m, double tolerance_rad) {
  const Pose off = a.inverse() * b;
  EXPECT_LT(off.translation().norm(), tolerance_m);
  EXPECT_LT(Eigen::AngleAxisd(off.linear()).angle(), tolerance_rad);
}

TEST(Registration, FindsTheMotionFromAGuessThatIsOff) {
  const Pose T = makeMotion(0.4, -0.3, 0.3);
  const RegisteredCloud target(makeRoom(1), {});
  const RegisteredCloud source = seenFrom(T, makeRoom(2));
  const Registration found = registerClouds(source, target, {T * makeMotion(0.2, 0.15, 0.1)}, {});
  expectNear(found.T_target_source, T, 0.02, 0.01);
  EXPECT_GT(found.overlap, 0.8);
  EXPECT_LT(found.rms_m, 0.02);
  EXPECT_GT(found.least_eigenvalue, 0.02);
}

TEST(Registration, FromFeaturesNeedsNoGuess) {
  const Pose T = makeMotion(0.8, -0.6, 2.0);
  const RegisteredCloud target(makeRoom(1), {});
  const RegisteredCloud source = seenFrom(T, makeRoom(2));
  Pose by_features;
  ASSERT_TRUE(alignByFeatures(source, target, {}, by_features));
  const Registration found = registerClouds(source, target, {by_features}, {});
  expectNear(found.T_target_source, T, 0.02, 0.01);
  Pose again;
  alignByFeatures(source, target, {}, again);
  EXPECT_EQ(again.matrix(), by_features.matrix());
}

TEST(Registration, TakesTheGuessThatFitsBest) {
  const Pose T = makeMotion(0.4, -0.3, 0.3);
  const RegisteredCloud target(makeRoom(1), {});
  const RegisteredCloud source = seenFrom(T, makeRoom(2));
  const auto found =
      registerClouds(source, target, {makeMotion(5.0, 5.0, 0.0), makeMotion(0.0, 0.0, 1.6), T}, {});
  expectNear(found.T_target_source, T, 0.02, 0.01);
}

TEST(Registration, OfACorridorCanSlide) {
  const RegisteredCloud target(makeCorridor(1), {});
  const RegisteredCloud source(makeCorridor(2), {});
  const Registration found = registerClouds(source, target, {Pose::Identity()}, {});
  EXPECT_GT(found.overlap, 0.7);
  EXPECT_LT(found.least_eigenvalue, 0.01);
}

TEST(Registration, WhatIsLeastFixedIsTheWayAlongTheCorridor) {
  const RegisteredCloud target(makeCorridor(1), {});
  for (const double yaw_rad : {0.0, 0.8, -2.0}) {
    const Pose T = makeMotion(0.2, 0.1, yaw_rad);
    const Registration found = registerClouds(seenFrom(T, makeCorridor(2)), target, {T}, {});
    const Eigen::SelfAdjointEigenSolver<trajectory::Matrix6d> solver(found.fixation);
    const Eigen::Vector3d along = T.linear().transpose() * Eigen::Vector3d::UnitX();
    const trajectory::Vector6d weakest = solver.eigenvectors().col(0);
    EXPECT_GT(std::abs(weakest.head<3>().dot(along)), 0.95) << yaw_rad;
    EXPECT_NEAR(solver.eigenvalues()(0), found.least_eigenvalue, 1e-9);
    EXPECT_GT(solver.eigenvalues()(1), 3.0 * found.least_eigenvalue);
  }
}

TEST(Registration, OfAnotherRoomHasLessOverlapThanOfTheSame) {
  const RegisteredCloud target(makeRoom(1), {});
  const RegisteredCloud same(makeRoom(2), {});
  const RegisteredCloud other(makeRoom(3, 1), {});
  const std::vector<Pose> guesses = {Pose::Identity(), makeMotion(0.0, 0.0, 1.57)};
  const double of_same = registerClouds(same, target, guesses, {}).overlap;
  const double of_other = registerClouds(other, target, guesses, {}).overlap;
  EXPECT_GT(of_same, of_other + 0.2);
}

TEST(Registration, OfNextToNothingIsNone) {
  const RegisteredCloud nothing(Points{}, {});
  const RegisteredCloud room(makeRoom(1), {});
  EXPECT_EQ(registerClouds(nothing, room, {Pose::Identity()}, {}).overlap, 0.0);
  EXPECT_EQ(registerClouds(room, nothing, {Pose::Identity()}, {}).overlap, 0.0);
  EXPECT_EQ(registerClouds(room, room, {}, {}).overlap, 0.0);
  Pose T;
  EXPECT_FALSE(alignByFeatures(nothing, room, {}, T));
  RegistrationConfig config;
  config.voxel_m = 0.0;
  EXPECT_THROW(RegisteredCloud(Points{}, config), config::ConfigError);
}

}  // namespace
}  // namespace tsg::loops
