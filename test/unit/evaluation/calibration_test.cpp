// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/calibration.h"

#include <gtest/gtest.h>

#include <random>

namespace tsg::evaluation {
namespace {

RotatedBox makeBox(double x, double size_m) {
  RotatedBox box;
  box.center_m = Eigen::Vector3d(x, 0.0, 0.0);
  box.size_m = Eigen::Vector3d::Constant(size_m);
  return box;
}

TEST(Calibration, ObjectsAreRightIfTheyAndAThingOfTheirNearestTaskHoldEachOther) {
  const std::vector<TaskTruth> truth{{"cup", {makeBox(0, 1), makeBox(5, 1)}}, {"piano", {}}};
  const std::vector<Estimate> estimates{{makeBox(5.2, 1), Eigen::Vector2d(0.3, 0.2)},
                                        {makeBox(5.2, 0.1), Eigen::Vector2d(0.29, 0.2)},
                                        {makeBox(0, 1), Eigen::Vector2d(0.2, 0.25)}};
  const auto objects = judgeObjects(truth, estimates);
  ASSERT_EQ(objects.size(), 3U);
  EXPECT_TRUE(objects[0].is_right);
  EXPECT_FALSE(objects[1].is_right);  // too small to hold the thing's centre
  EXPECT_FALSE(objects[2].is_right);  // nothing serves its task
  EXPECT_DOUBLE_EQ(objects[2].score, 0.25);
}

TEST(Calibration, BinsCountObjectsAndTheRightOnesAmongThem) {
  const Calibration calibration =
      computeCalibration({{0.30, true}, {0.305, false}, {0.21, false}, {0.2999, true}}, 0.01);
  ASSERT_EQ(calibration.bins.size(), 3U);
  EXPECT_NEAR(calibration.bins[0].low, 0.21, 1e-12);
  EXPECT_EQ(calibration.bins[0].num_right, 0U);
  EXPECT_NEAR(calibration.bins[1].low, 0.29, 1e-12);
  EXPECT_NEAR(calibration.bins[2].low, 0.30, 1e-12);
  EXPECT_EQ(calibration.bins[2].num_objects, 2U);
  EXPECT_EQ(calibration.bins[2].num_right, 1U);
  EXPECT_NEAR(calibration.bins[2].mean_score, 0.3025, 1e-12);
}

TEST(Calibration, SeparationIsOneIfAllRightOnesAreAboveAndHalfWithoutPairs) {
  EXPECT_DOUBLE_EQ(computeCalibration({{0.3, true}, {0.2, false}}, 0.1).separation, 1.0);
  EXPECT_DOUBLE_EQ(computeCalibration({{0.2, true}, {0.3, false}}, 0.1).separation, 0.0);
  EXPECT_DOUBLE_EQ(computeCalibration({{0.3, true}, {0.3, false}}, 0.1).separation, 0.5);
  EXPECT_DOUBLE_EQ(computeCalibration({{0.3, true}}, 0.1).separation, 0.5);
  EXPECT_DOUBLE_EQ(computeCalibration({}, 0.1).separation, 0.5);
  EXPECT_THROW(computeCalibration({}, 0.0), std::invalid_argument);
}

TEST(Calibration, SeparationIsTheShareOfOrderedPairs) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> draw(0, 9);
  std::vector<ScoredObject> objects;
  for (int i = 0; i < 60; ++i) objects.push_back({0.1 * draw(random), draw(random) < 4});
  double ordered = 0.0;
  double pairs = 0.0;
  for (const ScoredObject& a : objects) {
    for (const ScoredObject& b : objects) {
      if (!a.is_right || b.is_right) continue;
      pairs += 1.0;
      ordered += a.score > b.score ? 1.0 : (a.score == b.score ? 0.5 : 0.0);
    }
  }
  EXPECT_NEAR(computeCalibration(objects, 0.05).separation, ordered / pairs, 1e-12);
}

TEST(Calibration, RefusesObjectsWithoutACosineForEachTask) {
  EXPECT_THROW(judgeObjects({{"cup", {makeBox(0, 1)}}}, {{makeBox(0, 1), Eigen::Vector2d(1, 0)}}),
               std::invalid_argument);
}

}  // namespace
}  // namespace tsg::evaluation
