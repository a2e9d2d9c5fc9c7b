// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/object_scores.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace tsg::evaluation {
namespace {

constexpr double kTolerance = 1e-6;

RotatedBox makeBox(const Eigen::Vector3d& center, const Eigen::Vector3d& size = {1, 1, 1},
                   double yaw_deg = 0.0) {
  const double yaw_rad = yaw_deg * M_PI / 180.0;
  return {center, size, Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix()};
}

/// From `begin` to `end` along x, with a unit section.
RotatedBox makeBar(double begin, double end) {
  return makeBox({(begin + end) / 2.0, 0, 0}, {end - begin, 1, 1});
}

Estimate makeEstimate(const RotatedBox& box, const std::vector<double>& cosines) {
  return {box, Eigen::Map<const Eigen::VectorXd>(cosines.data(),
                                                 static_cast<Eigen::Index>(cosines.size()))};
}

struct Expected {
  double recall_strict;
  double recall_relaxed;
  double precision_strict;
  double precision_relaxed;
  double iou;
};

struct Case {
  std::string name;
  std::vector<TaskTruth> truth;
  std::vector<Estimate> estimates;
  Expected paper;
  Expected as_released;
};

std::ostream& operator<<(std::ostream& out, const Case& c) { return out << c.name; }

Case makeCase(const std::string& name, const std::vector<TaskTruth>& truth,
              const std::vector<Estimate>& estimates, const Expected& paper,
              const Expected& as_released) {
  return {name, truth, estimates, paper, as_released};
}

Case makeCase(const std::string& name, const std::vector<TaskTruth>& truth,
              const std::vector<Estimate>& estimates, const Expected& both) {
  return {name, truth, estimates, both, both};
}

std::vector<Case> makeCases() {
  const RotatedBox unit = makeBox({0, 0, 0});
  const std::vector<TaskTruth> one{{"A", {unit}}};
  const auto crowd = [&](double third) {
    return std::vector<Estimate>{makeEstimate(makeBox({9, 0, 0}), {.30}), makeEstimate(unit, {.28}),
                                 makeEstimate(makeBox({5, 0, 0}), {third})};
  };
  return {
      makeCase("Identical", one, {makeEstimate(unit, {.3})}, {1, 1, 1, 1, 1}),
      makeCase("BigEstimate", {{"A", {makeBox({.6, 0, 0}, {.2, .2, .2})}}},
               {makeEstimate(makeBox({0, 0, 0}, {2, 2, 2}), {.3})}, {0, 1, 0, 1, .001}),
      makeCase("SmallEstimateInBigTruth", {{"A", {makeBox({0, 0, 0}, {2, 2, 2})}}},
               {makeEstimate(makeBox({.6, 0, 0}, {.2, .2, .2}), {.3})}, {0, 1, 0, 1, .001},
               {0, 0, 0, 0, .001}),
      makeCase("DoubledSides", one, {makeEstimate(makeBox({.8, 0, 0}), {.3})},
               {0, 0, 0, 0, 1.0 / 9}, {1, 1, 1, 1, 1.0 / 9}),
      makeCase("TurnedTruth", {{"A", {makeBox({0, 0, 0}, {4, .4, 1}, 90)}}},
               {makeEstimate(makeBox({0, 1.5, 0}, {.4, .4, .4}), {.3})}, {0, 1, 0, 1, .04},
               {0, 0, 0, 0, .04}),
      makeCase("OfEqualCosinesTheFirst", one,
               {makeEstimate(makeBox({9, 0, 0}), {.3}), makeEstimate(unit, {.3})},
               {0, 0, .5, .5, 0}),
      makeCase("PairsOfLargestOverlapFirst", {{"A", {makeBar(0, 1), makeBar(1, 2)}}},
               {makeEstimate(makeBar(.4, 1.4), {.3}), makeEstimate(makeBar(-.45, .55), {.3})},
               {.5, .5, .5, .5, .214286}),
      makeCase("MoreEstimatesThanTruths", one, crowd(.26), {0, 0, .5, .5, 0}),
      makeCase("NineTenthsOfTheBest", one, crowd(.27), {0, 0, 1.0 / 3, 1.0 / 3, 0},
               {0, 0, .5, .5, 0}),
      makeCase("FewerEstimatesThanTruths", {{"A", {unit, makeBox({5, 0, 0}), makeBox({9, 0, 0})}}},
               {makeEstimate(makeBox({.5, 0, 0}), {.3})}, {1.0 / 3, 1.0 / 3, 1, 1, 1.0 / 9}),
      makeCase("WeakThird", {{"A", {unit}}, {"B", {makeBox({4, 0, 0})}}},
               {makeEstimate(unit, {.30, .29}), makeEstimate(makeBox({9, 0, 0}), {.20, .31}),
                makeEstimate(makeBox({7, 7, 0}), {.22, .10})},
               {.5, .5, .5, .5, .5}),
      makeCase("OneObjectForTwoTasks", {{"A", {unit}}, {"B", {unit}}},
               {makeEstimate(unit, {.3, .3})}, {1, 1, 1, 1, 1}),
      makeCase("TaskWithoutTruth", {{"A", {unit}}, {"B", {}}},
               {makeEstimate(unit, {.3, .1}), makeEstimate(makeBox({5, 0, 0}), {.1, .3})},
               {1, 1, .5, .5, 1}),
      makeCase("NegativeCosines", one, {makeEstimate(unit, {-.1})}, {1, 1, 0, 0, 1}),
      makeCase("Turned45Degrees", one, {makeEstimate(makeBox({0, 0, 0}, {1, 1, 1}, 45), {.3})},
               {1, 1, 1, 1, std::sqrt(.5)}),
      makeCase("TurnedTruthAndLongEstimate", {{"A", {makeBox({0, 0, 0}, {2, 1, 1}, 30)}}},
               {makeEstimate(makeBox({1.2, 0, 0}, {3, .4, 1}), {.3})}, {0, 1, 0, 1, .184997},
               {1, 1, 1, 1, .184997}),
      makeCase("EmptyMap", one, {}, {0, 0, 0, 0, 0}),
  };
}

class WorkedCase : public testing::TestWithParam<Case> {};

double computeF1(double recall, double precision) {
  return recall + precision > 0.0 ? 2.0 * recall * precision / (recall + precision) : 0.0;
}

void expectScores(const ObjectScores& scores, const Expected& expected) {
  EXPECT_NEAR(scores.strict.recall, expected.recall_strict, kTolerance);
  EXPECT_NEAR(scores.relaxed.recall, expected.recall_relaxed, kTolerance);
  EXPECT_NEAR(scores.strict.precision, expected.precision_strict, kTolerance);
  EXPECT_NEAR(scores.relaxed.precision, expected.precision_relaxed, kTolerance);
  EXPECT_NEAR(scores.strict.f1, computeF1(expected.recall_strict, expected.precision_strict),
              kTolerance);
  EXPECT_NEAR(scores.relaxed.f1, computeF1(expected.recall_relaxed, expected.precision_relaxed),
              kTolerance);
  EXPECT_NEAR(scores.iou, expected.iou, kTolerance);
}

TEST_P(WorkedCase, AsThePaperWordsIt) {
  const Case& c = GetParam();
  expectScores(computeObjectScores(c.truth, c.estimates, ScoreMode::kPaper), c.paper);
}

TEST_P(WorkedCase, AsReleased) {
  const Case& c = GetParam();
  expectScores(computeObjectScores(c.truth, c.estimates, ScoreMode::kAsReleased), c.as_released);
}

INSTANTIATE_TEST_SUITE_P(ObjectScores, WorkedCase, testing::ValuesIn(makeCases()),
                         [](const auto& test) { return test.param.name; });

TEST(ObjectScores, DenominatorsAndRowsOfTasks) {
  for (const Case& c : makeCases()) {
    if (c.name != "WeakThird") continue;
    const ObjectScores scores = computeObjectScores(c.truth, c.estimates, ScoreMode::kPaper);
    EXPECT_EQ(scores.num_objects, 3U);
    EXPECT_EQ(scores.num_true, 2U);
    EXPECT_EQ(scores.num_kept, 2U);
    ASSERT_EQ(scores.tasks.size(), 2U);
    EXPECT_EQ(scores.tasks[0].task, "A");
    EXPECT_EQ(scores.tasks[0].num_kept, 1U);
    EXPECT_EQ(scores.tasks[0].correct_strict, 1U);
    EXPECT_EQ(scores.tasks[1].task, "B");
    EXPECT_EQ(scores.tasks[1].num_kept, 1U);
    EXPECT_EQ(scores.tasks[1].correct_strict, 0U);
  }
}

TEST(ObjectScores, TruthWithoutBoxesIsRefused) {
  EXPECT_THROW(computeObjectScores({{"A", {}}}, {}, ScoreMode::kPaper), std::invalid_argument);
  EXPECT_THROW(computeObjectScores({}, {}, ScoreMode::kPaper), std::invalid_argument);
}

TEST(ObjectScores, EstimateWithOtherNumberOfCosinesIsRefused) {
  const RotatedBox unit = makeBox({0, 0, 0});
  EXPECT_THROW(
      computeObjectScores({{"A", {unit}}}, {makeEstimate(unit, {.3, .2})}, ScoreMode::kPaper),
      std::invalid_argument);
}

// --- Properties ---------------------------------------------------------------------------------

using Random = std::mt19937;

RotatedBox makeRandomBox(Random& random) {
  std::uniform_real_distribution<double> center(-2.0, 2.0);
  std::uniform_real_distribution<double> size(0.3, 2.0);
  std::normal_distribution<double> normal;
  const Eigen::Quaterniond rotation(normal(random), normal(random), normal(random), normal(random));
  return {{center(random), center(random), center(random)},
          {size(random), size(random), size(random)},
          rotation.normalized().toRotationMatrix()};
}

struct World {
  std::vector<TaskTruth> truth;
  std::vector<Estimate> estimates;
};

World makeWorld(Random& random) {
  std::uniform_int_distribution<int> count(0, 3);
  std::uniform_real_distribution<double> cosine(0.05, 0.35);
  World world{{{"0", {makeRandomBox(random)}}}, {}};
  for (const char* const name : {"1", "2", "3"}) {
    world.truth.push_back({name, {}});
    for (int i = count(random); i > 0; --i) {
      world.truth.back().boxes.push_back(makeRandomBox(random));
    }
  }
  for (int i = 0; i < 12; ++i) {
    Estimate estimate{makeRandomBox(random), Eigen::VectorXd(4)};
    for (Eigen::Index k = 0; k < 4; ++k) estimate.cosines[k] = cosine(random);
    world.estimates.push_back(estimate);
  }
  return world;
}

class RandomWorld : public testing::TestWithParam<int> {
 protected:
  Random random_{static_cast<unsigned>(GetParam())};
  World world_ = makeWorld(random_);

  void expectSameScores(const World& other, ScoreMode mode) const {
    const ObjectScores a = computeObjectScores(world_.truth, world_.estimates, mode);
    const ObjectScores b = computeObjectScores(other.truth, other.estimates, mode);
    expectScores(
        b, {a.strict.recall, a.relaxed.recall, a.strict.precision, a.relaxed.precision, a.iou});
  }

  World moved(const Eigen::Isometry3d& motion) const {
    World world = world_;
    const auto move = [&](RotatedBox& box) {
      box.center_m = motion * box.center_m;
      box.rotation = motion.linear() * box.rotation;
    };
    for (TaskTruth& task : world.truth) std::for_each(task.boxes.begin(), task.boxes.end(), move);
    for (Estimate& estimate : world.estimates) move(estimate.box);
    return world;
  }
};

constexpr ScoreMode kModes[] = {ScoreMode::kPaper, ScoreMode::kAsReleased};

TEST_P(RandomWorld, StrictIsNeverAboveRelaxed) {
  for (const ScoreMode mode : kModes) {
    const ObjectScores scores = computeObjectScores(world_.truth, world_.estimates, mode);
    EXPECT_LE(scores.strict.recall, scores.relaxed.recall);
    EXPECT_LE(scores.strict.precision, scores.relaxed.precision);
  }
}

TEST_P(RandomWorld, OrderOfObjectsDoesNotMatter) {
  World other = world_;
  std::shuffle(other.estimates.begin(), other.estimates.end(), random_);
  for (const ScoreMode mode : kModes) expectSameScores(other, mode);
}

TEST_P(RandomWorld, OrderOfTasksDoesNotMatter) {
  World other = world_;
  std::reverse(other.truth.begin(), other.truth.end());
  for (Estimate& estimate : other.estimates) estimate.cosines.reverseInPlace();
  for (const ScoreMode mode : kModes) expectSameScores(other, mode);
}

TEST_P(RandomWorld, MovingAllBoxesDoesNotMatter) {
  const Eigen::Isometry3d shift(Eigen::Translation3d(412000.0, 5300000.0, 100.0));
  for (const ScoreMode mode : kModes) expectSameScores(moved(shift), mode);
}

TEST_P(RandomWorld, TurningAllBoxesDoesNotMatterToThePaper) {
  const Eigen::Isometry3d turn(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  expectSameScores(moved(turn), ScoreMode::kPaper);
}

INSTANTIATE_TEST_SUITE_P(ObjectScores, RandomWorld, testing::Range(0, 20));

TEST(ObjectScores, CenterErrorIsOfTheNearestOfATasksObjects) {
  const std::vector<TaskTruth> truth{{"cup", {makeBox({0, 0, 0}), makeBox({5, 0, 0})}},
                                     {"pot", {makeBox({9, 0, 0})}}};
  const std::vector<Estimate> estimates{makeEstimate(makeBox({0, 0.1, 0}), {0.3, 0.1}),
                                        makeEstimate(makeBox({5, 0, 0.4}), {0.3, 0.1}),
                                        makeEstimate(makeBox({9, 3, 0}), {0.1, 0.3})};
  const auto scores = computeObjectScores(truth, estimates, ScoreMode::kPaper);
  ASSERT_TRUE(scores.center_error_m);
  EXPECT_NEAR(*scores.center_error_m, 0.4, kTolerance) << "median of 0.1, 0.4 and 3";
  EXPECT_FALSE(computeObjectScores(truth, {}, ScoreMode::kPaper).center_error_m);
}

}  // namespace
}  // namespace tsg::evaluation
