// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/rotated_box.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tsg {
namespace {

RotatedBox makeBox(const Eigen::Vector3d& center, const Eigen::Vector3d& size,
                   const Eigen::AngleAxisd& rotation = Eigen::AngleAxisd::Identity()) {
  return {center, size, rotation.toRotationMatrix()};
}

RotatedBox makeUnit(const Eigen::Vector3d& center = Eigen::Vector3d::Zero()) {
  return makeBox(center, {1, 1, 1});
}

TEST(RotatedBox, IouOfABoxAndItselfIsOne) {
  const RotatedBox box =
      makeBox({1, 2, 3}, {1, 2, 3}, Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 1, 1).normalized()));
  EXPECT_NEAR(computeIou(box, box), 1.0, 1e-12);
}

TEST(RotatedBox, HalfCovered) {
  EXPECT_NEAR(computeIntersectionVolume(makeUnit(), makeUnit({0.5, 0, 0})), 0.5, 1e-12);
  EXPECT_NEAR(computeIou(makeUnit(), makeUnit({0.5, 0, 0})), 1.0 / 3.0, 1e-12);
}

TEST(RotatedBox, BoxesThatTouchShareNothing) {
  EXPECT_EQ(computeIntersectionVolume(makeUnit(), makeUnit({1, 0, 0})), 0.0);
  EXPECT_EQ(computeIou(makeUnit(), makeUnit({1, 1, 1})), 0.0);
  EXPECT_EQ(computeIou(makeUnit(), makeUnit({3, 0, 0})), 0.0);
}

TEST(RotatedBox, OneInsideTheOther) {
  const RotatedBox inner =
      makeBox({0.1, 0, 0}, {0.2, 0.3, 0.4}, Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitX()));
  EXPECT_NEAR(computeIntersectionVolume(inner, makeBox({0, 0, 0}, {2, 2, 2})), 0.024, 1e-12);
  EXPECT_NEAR(computeIntersectionVolume(makeBox({0, 0, 0}, {2, 2, 2}), inner), 0.024, 1e-12);
}

TEST(RotatedBox, OctagonOfASquareTurnedByAnEighth) {
  const RotatedBox turned =
      makeBox({0, 0, 0}, {1, 1, 1}, Eigen::AngleAxisd(M_PI / 4, Eigen::Vector3d::UnitZ()));
  EXPECT_NEAR(computeIntersectionVolume(makeUnit(), turned), 2.0 * (std::sqrt(2.0) - 1.0), 1e-12);
}

TEST(RotatedBox, CornerCutOffByADiagonalPlane) {
  // A large box whose face is the plane x + y + z = 1 keeps a tetrahedron of volume 1/6.
  const Eigen::Vector3d normal = Eigen::Vector3d::Ones().normalized();
  RotatedBox half = makeBox(normal * (1.0 / std::sqrt(3.0) - 5.0), {10, 10, 10});
  half.rotation =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitX(), normal).toRotationMatrix();
  EXPECT_NEAR(computeIntersectionVolume(makeUnit({0.5, 0.5, 0.5}), half), 1.0 / 6.0, 1e-12);
}

TEST(RotatedBox, FlatBoxesHaveNoIou) {
  EXPECT_EQ(computeIou(makeBox({0, 0, 0}, {1, 1, 0}), makeUnit()), 0.0);
  EXPECT_EQ(computeIou(RotatedBox(), RotatedBox()), 0.0);
}

TEST(RotatedBox, FarFromTheOriginAsNearIt) {
  const Eigen::Vector3d far(412000.0, 5300000.0, 100.0);
  EXPECT_NEAR(computeIou(makeUnit(far), makeUnit(far + Eigen::Vector3d(0.5, 0, 0))), 1.0 / 3.0,
              1e-9);
}

TEST(RotatedBox, FacesAreInside) {
  EXPECT_TRUE(makeUnit().contains({0.5, 0, 0}));
  EXPECT_TRUE(makeUnit().contains({0.5, 0.5, -0.5}));
  EXPECT_FALSE(makeUnit().contains({0.5 + 1e-9, 0, 0}));
}

// Brute force: the share of one box's points that the other contains.
double sampleIntersection(const RotatedBox& a, const RotatedBox& b) {
  constexpr int kSteps = 60;
  int inside = 0;
  for (int i = 0; i < kSteps * kSteps * kSteps; ++i) {
    const Eigen::Vector3d cell(i % kSteps, i / kSteps % kSteps, i / kSteps / kSteps);
    const Eigen::Vector3d unit = (cell.array() + 0.5) / kSteps - 0.5;
    const Eigen::Vector3d p_box = unit.cwiseProduct(a.size_m);
    if (b.contains(a.center_m + a.rotation * p_box)) ++inside;
  }
  return a.volume() * inside / (kSteps * kSteps * kSteps);
}

class RandomBoxes : public testing::TestWithParam<int> {};

TEST_P(RandomBoxes, IntersectionAgreesWithSampling) {
  std::mt19937 random(static_cast<unsigned>(GetParam()));
  std::uniform_real_distribution<double> center(-0.7, 0.7);
  std::uniform_real_distribution<double> size(0.2, 2.0);
  std::normal_distribution<double> normal;
  const auto make = [&] {
    const Eigen::Vector3d p(center(random), center(random), center(random));
    const Eigen::Vector3d s(size(random), size(random), size(random));
    const Eigen::Quaterniond q(normal(random), normal(random), normal(random), normal(random));
    return RotatedBox{p, s, q.normalized().toRotationMatrix()};
  };
  const RotatedBox a = make();
  const RotatedBox b = make();
  const double volume = computeIntersectionVolume(a, b);
  EXPECT_NEAR(volume, sampleIntersection(a, b), 0.01 * a.volume());
  EXPECT_NEAR(volume, computeIntersectionVolume(b, a), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(RotatedBox, RandomBoxes, testing::Range(0, 40));

}  // namespace
}  // namespace tsg
