// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/calibration.h"

#include <gtest/gtest.h>

#include <algorithm>
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

TEST(PrecisionRecall, OfThreeObjectsTwoOfWhichAreRightAboutOneThing) {
  const std::vector<TaskTruth> truth{{"cup", {makeBox(0, 1), makeBox(5, 1)}}, {"piano", {}}};
  const std::vector<Estimate> estimates{{makeBox(0.1, 1), Eigen::Vector2d(0.32, 0.2)},
                                        {makeBox(-0.1, 1), Eigen::Vector2d(0.30, 0.2)},
                                        {makeBox(9, 1), Eigen::Vector2d(0.29, 0.2)}};
  const auto curve = computePrecisionRecall(truth, estimates, 0.01);
  ASSERT_EQ(curve.size(), 4U);
  EXPECT_NEAR(curve[0].min_score, 0.29, 1e-12);
  EXPECT_DOUBLE_EQ(curve[0].precision, 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(curve[0].recall, 0.5);
  EXPECT_DOUBLE_EQ(curve[1].precision, 1.0);
  EXPECT_DOUBLE_EQ(curve[2].precision, 1.0);  // from 0.31 on one is left
  EXPECT_DOUBLE_EQ(curve[3].recall, 0.5);
  EXPECT_TRUE(computePrecisionRecall(truth, {}, 0.01).empty());
  EXPECT_THROW(computePrecisionRecall(truth, estimates, 0.0), std::invalid_argument);
}

TEST(PrecisionRecall, IsThatOfTheMapWithoutTheLowerOnes) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> draw(0.0, 1.0);
  std::vector<TaskTruth> truth{{"cup", {}}, {"piano", {}}};
  for (int i = 0; i < 12; ++i) truth[i % 2].boxes.push_back(makeBox(6.0 * draw(random), 1));
  std::vector<Estimate> estimates;
  for (int i = 0; i < 40; ++i) {
    estimates.push_back(
        {makeBox(6.0 * draw(random), 1), Eigen::Vector2d(draw(random), draw(random))});
  }
  for (const CurvePoint& point : computePrecisionRecall(truth, estimates, 0.05)) {
    std::vector<Estimate> left;
    for (const Estimate& estimate : estimates) {
      if (estimate.cosines.maxCoeff() >= point.min_score) left.push_back(estimate);
    }
    double num_right = 0.0;
    for (const auto& object : judgeObjects(truth, left)) num_right += object.is_right ? 1.0 : 0.0;
    EXPECT_NEAR(point.precision, num_right / static_cast<double>(left.size()), 1e-12);
    double num_found = 0.0;
    for (const TaskTruth& task : truth) {
      for (const RotatedBox& thing : task.boxes) {
        // Of one thing and its task alone: is any object right?
        std::vector<TaskTruth> one{{truth[0].task, {}}, {truth[1].task, {}}};
        one[&task == &truth[0] ? 0 : 1].boxes = {thing};
        const auto objects = judgeObjects(one, left);
        num_found += std::any_of(objects.begin(), objects.end(),
                                 [](const ScoredObject& object) { return object.is_right; })
                         ? 1.0
                         : 0.0;
      }
    }
    EXPECT_NEAR(point.recall, num_found / 12.0, 1e-12);
  }
}

TEST(Calibration, RefusesObjectsWithoutACosineForEachTask) {
  EXPECT_THROW(judgeObjects({{"cup", {makeBox(0, 1)}}}, {{makeBox(0, 1), Eigen::Vector2d(1, 0)}}),
               std::invalid_argument);
}

}  // namespace
}  // namespace tsg::evaluation
