// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/trajectory/deformation.h"

#include <gtest/gtest.h>

#include "graph_worlds.h"

namespace tsg::trajectory {
namespace {

/// Keyframes each 1 m along x.
Keyframes makeWay(int num) {
  Keyframes keyframes("world");
  for (int i = 0; i < num; ++i) keyframes.add({i}, makePose(i, 0.0, 1.5));
  return keyframes;
}

/// Keyframe i is turned by i times the angle, and shifted.
Correction makeBend(const Keyframes& keyframes, double angle_rad) {
  std::vector<KeyframeMotion> motions;
  for (const Keyframe& keyframe : keyframes.list()) {
    const double i = static_cast<double>(keyframe.id.value - 1);
    motions.push_back({keyframe.id, makePose(0.02 * i, 0.0, 0.0, angle_rad * i)});
  }
  return Correction(motions);
}

/// The motion by the definition, over all keyframes.
Pose computeByBruteForce(const Keyframes& keyframes, const Correction& correction,
                         const Eigen::Vector3d& p_m, std::size_t count) {
  std::vector<std::pair<double, KeyframeId>> by_distance;
  for (const Keyframe& keyframe : keyframes.list()) {
    by_distance.emplace_back((keyframe.T_world_camera.translation() - p_m).norm(), keyframe.id);
  }
  std::sort(by_distance.begin(), by_distance.end());
  std::vector<std::pair<Pose, double>> motions;
  double sum = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double weight = std::pow(1.0 - by_distance[i].first / by_distance[count].first, 2);
    motions.emplace_back(correction.at({{by_distance[i].second, 1.0}}), weight);
    sum += weight;
  }
  for (auto& motion : motions) motion.second /= sum;
  return blend(motions);
}

TEST(Deformation, IsTheWeightedBlendOfTheNearestKeyframes) {
  const Keyframes keyframes = makeWay(30);
  const Correction correction = makeBend(keyframes, 0.02);
  const Deformation deformation(keyframes, correction);
  Noise noise(5);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d p_m =
        makePose(15.0, 0.0, 1.0).translation() + 8.0 * noise.draw(1.0, 0.0).translation();
    EXPECT_TRUE(deformation.motionAt(p_m).isApprox(
        computeByBruteForce(keyframes, correction, p_m, 4), 1e-9))
        << p_m.transpose();
  }
}

TEST(Deformation, IsContinuous) {
  const Keyframes keyframes = makeWay(30);
  const Deformation deformation(keyframes, makeBend(keyframes, 0.02));
  Eigen::Vector3d last_m = Eigen::Vector3d::Zero();
  for (int i = 0; i <= 20000; ++i) {
    const Eigen::Vector3d p_m(2.0 + 0.001 * i, 2.0, 0.3);
    const Eigen::Vector3d moved_m = deformation.motionAt(p_m) * p_m;
    if (i > 0) {
      ASSERT_LT((moved_m - last_m).norm(), 0.005) << p_m.transpose();
    }
    last_m = moved_m;
  }
}

TEST(Deformation, DoesNotDependOnTheOrderOfKeyframesAlongX) {
  const Keyframes forward = makeWay(20);
  Keyframes backward("world");
  for (int i = 0; i < 20; ++i) backward.add({i}, makePose(19 - i, 0.0, 1.5));
  std::vector<KeyframeMotion> motions = makeBend(forward, 0.02).motions();
  std::reverse(motions.begin(), motions.end());
  for (std::size_t i = 0; i < 20; ++i) motions[i].id = KeyframeId{i + 1};
  const Deformation a(forward, makeBend(forward, 0.02));
  const Deformation b(backward, Correction(motions));
  for (double x_m = -1.0; x_m < 21.0; x_m += 0.37) {
    const Eigen::Vector3d p_m(x_m, 0.4, 0.0);
    EXPECT_TRUE(a.motionAt(p_m).isApprox(b.motionAt(p_m), 1e-12)) << x_m;
  }
}

TEST(Deformation, WithFewKeyframesTakesAllThereAre) {
  const Keyframes one = makeWay(1);
  const Pose motion = makePose(1.0, 2.0, 3.0, 0.5);
  const Deformation rigid(one, makeRigidCorrection(one, motion));
  EXPECT_EQ(rigid.motionAt({9.0, 9.0, 9.0}).matrix(), motion.matrix());
  const Keyframes two = makeWay(2);
  const Deformation pair(two, makeBend(two, 0.1));
  // The farther one has no weight.
  EXPECT_TRUE(pair.motionAt({0.1, 0.0, 0.0}).isApprox(Pose::Identity()));
  // At one distance from both.
  EXPECT_TRUE(isRigid(pair.motionAt({0.5, 0.0, 0.0})));
  EXPECT_THROW(Deformation(Keyframes("world"), makeBend(two, 0.1)), std::invalid_argument);
}

TEST(Deformation, VerticesMoveAsTheFieldDoesUpToTheSizeOfACell) {
  const Keyframes keyframes = makeWay(30);
  DeformationConfig config;
  config.cell_m = 0.5;
  Deformation deformation(keyframes, makeBend(keyframes, 0.01), config);
  Mesh mesh;
  for (int i = 0; i < 2000; ++i) {
    mesh.vertices.emplace_back(static_cast<float>(i % 29), static_cast<float>(i % 7) - 3.0F,
                               static_cast<float>(i % 11) * 0.2F);
  }
  const Mesh before = mesh;
  ASSERT_TRUE(deformation.moveVertices(mesh));
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3d p_m = before.vertices[i].cast<double>();
    const Eigen::Vector3d expected_m = deformation.motionAt(p_m) * p_m;
    EXPECT_LT((mesh.vertices[i].cast<double>() - expected_m).norm(), 0.03) << p_m.transpose();
  }
}

TEST(Deformation, VerticesAtCornersMoveExactlyAndWhatIsStillKeepsItsBits) {
  const Keyframes keyframes = makeWay(30);
  std::vector<KeyframeMotion> motions;
  for (const Keyframe& keyframe : keyframes.list()) {
    const bool moves = keyframe.id.value > 15;
    motions.push_back({keyframe.id, moves ? makePose(0.0, 0.0, 0.25) : Pose::Identity()});
  }
  Deformation deformation(keyframes, Correction(motions));
  Mesh still;
  still.vertices = {{1.1F, 2.3F, 0.7F}, {5.3F, -1.7F, 0.1F}};
  const Mesh before = still;
  EXPECT_FALSE(deformation.moveVertices(still));
  EXPECT_EQ(still.vertices, before.vertices);
  Mesh moving;
  moving.vertices = {{25.0F, 2.0F, 1.0F}, {27.3F, -1.7F, 0.1F}};
  EXPECT_TRUE(deformation.moveVertices(moving));
  EXPECT_EQ(moving.vertices[0], Eigen::Vector3f(25.0F, 2.0F, 1.25F));
  EXPECT_EQ(moving.vertices[1], Eigen::Vector3f(27.3F, -1.7F, 0.35F));
}

}  // namespace
}  // namespace tsg::trajectory
