// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/region_scores.h"

#include <gtest/gtest.h>

#include <random>

namespace tsg::evaluation {
namespace {

constexpr double kTolerance = 1e-6;

struct Case {
  std::string name;
  RegionOverlaps overlaps;
  double precision;
  double recall;
  double f1;
  double total_precision;
  double total_recall;
};

RegionOverlaps makeOverlaps(const Eigen::MatrixXd& overlaps, const Eigen::VectorXd& room_sizes,
                            const Eigen::VectorXd& region_sizes) {
  return {overlaps, room_sizes, region_sizes};
}

Eigen::MatrixXd fill(Eigen::Index rows, const std::vector<double>& values) {
  const auto cols = static_cast<Eigen::Index>(values.size()) / rows;
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      values.data(), rows, cols);
}

Eigen::VectorXd list(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

const std::vector<double> kMixed{70, 20, 10, 40};  // rooms x regions of R4
const std::vector<double> kMixedAndC{70, 20, 0, 10, 40, 0};

class WorkedCases : public ::testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(
    RoomMetric, WorkedCases,
    ::testing::Values(
        Case{"OneRegionTooSmall", makeOverlaps(fill(1, {80}), list({100}), list({80})), 1, .8,
             .888889, 1, .8},
        Case{"OverSegmented", makeOverlaps(fill(1, {60, 40}), list({100}), list({60, 40})), 1, .6,
             .75, 1, .6},
        Case{"UnderSegmented", makeOverlaps(fill(2, {100, 50}), list({100, 50}), list({150})),
             .666667, 1, .8, .666667, 1},
        Case{"Mixed", makeOverlaps(fill(2, kMixed), list({100, 60}), list({80, 60})), .770833,
             .683333, .724451, .785714, .6875},
        Case{"OneMoreOutsideOfAllRooms",
             makeOverlaps(fill(2, kMixedAndC), list({100, 60}), list({80, 60, 20})), .513889,
             .683333, .586620, .6875, .6875},
        Case{"OneMoreOutsideOfAllRoomsOnlyLabeled",
             makeOverlaps(fill(2, kMixedAndC), list({100, 60}), list({80, 60, 0})), .513889,
             .683333, .586620, .785714, .6875},
        Case{"OverlappingRegions", makeOverlaps(fill(1, {100, 30}), list({100}), list({100, 30})),
             1, 1, 1, 1, 1}),
    [](const auto& test) { return test.param.name; });

TEST_P(WorkedCases, HaveTheirScores) {
  const RegionScores scores = computeRegionScores(GetParam().overlaps);
  EXPECT_NEAR(scores.precision, GetParam().precision, kTolerance);
  EXPECT_NEAR(scores.recall, GetParam().recall, kTolerance);
  EXPECT_NEAR(scores.f1, GetParam().f1, kTolerance);
  EXPECT_NEAR(scores.total_precision, GetParam().total_precision, kTolerance);
  EXPECT_NEAR(scores.total_recall, GetParam().total_recall, kTolerance);
}

TEST(RoomMetric, IsZeroWithoutRegionsOrRooms) {
  const RegionScores no_region = computeRegionScores(computeOverlaps({0, 0, 1}, 2, {}, true));
  EXPECT_EQ(no_region.f1, 0.0);
  EXPECT_EQ(no_region.room_recalls, (std::vector<double>{0.0, 0.0}));
  const RegionScores no_room =
      computeRegionScores(computeOverlaps({kOutside, kOutside}, 0, {{0, 1}}, false));
  EXPECT_EQ(no_room.f1, 0.0);
  EXPECT_EQ(no_room.region_precisions, (std::vector<double>{0.0}));
}

TEST(RoomMetric, LeavesSamplesOutsideOfAllRoomsOutOnlyIfAsked) {
  const std::vector<int> room_of_samples{0, 0, 1, kOutside, kOutside};
  const std::vector<SampleSet> regions{{0, 2, 3}, {3, 4}};
  const RegionOverlaps all = computeOverlaps(room_of_samples, 2, regions, false);
  EXPECT_EQ(all.region_sizes, Eigen::Vector2d(3, 2));
  EXPECT_EQ(all.room_sizes, Eigen::Vector2d(2, 1));
  EXPECT_EQ(all.overlaps, (Eigen::Matrix2d() << 1, 0, 1, 0).finished());
  EXPECT_EQ(computeOverlaps(room_of_samples, 2, regions, true).region_sizes, Eigen::Vector2d(2, 0));
}

OrientedBox makeBox(const Eigen::Vector3d& center_m, const Eigen::Vector3d& size_m,
                    double yaw_rad = 0.0) {
  OrientedBox box;
  box.center_m = center_m;
  box.size_m = size_m;
  box.yaw_rad = yaw_rad;
  return box;
}

TEST(RoomsOfSamples, AreUnionsOfTurnedBoxesOfWhichTheFirstOwnsAPoint) {
  const double quarter_rad = std::atan(1.0);
  const std::vector<TrueRoom> rooms{
      {"turned", {makeBox({0, 0, 1}, {2, 2, 2}, -quarter_rad), makeBox({9, 0, 1}, {2, 2, 2})}},
      {"straight", {makeBox({0, 0, 1}, {4, 4, 2})}}};
  const SamplePoints samples_m{{0, 0, 1},   {1.3, 0, 1}, {0.9, 0.9, 1},
                               {9, 0.5, 1}, {0, 0, 2.5}, {5, 0, 1}};
  EXPECT_EQ(findRoomOfSamples(samples_m, rooms),
            (std::vector<int>{0, 0, 1, 0, kOutside, kOutside}));
}

PlaceGraph makeTwoPlaces() {
  PlaceGraph graph;
  graph.places = {{{1}, {0, 0, 1}, 1.0, {}, 0}, {{2}, {3, 0, 1}, 0.5, {}, 0}};
  return graph;
}

TEST(RegionSamples, AreThoseWithinTheClearanceOfOneOfItsPlaces) {
  const SamplePoints samples_m{{1, 0, 1}, {1.01, 0, 1}, {0, 0, 1.9}, {0.8, 0, 1.8}, {3.4, 0, 1}};
  const std::vector<std::vector<PlaceId>> regions{{{1}, {2}}, {{2}, {7}}};
  EXPECT_EQ(collectRegionSamples(samples_m, makeTwoPlaces(), regions, PlaceShape::kSphere),
            (std::vector<SampleSet>{{0, 2, 4}, {4}}));
  EXPECT_EQ(collectRegionSamples(samples_m, makeTwoPlaces(), regions, PlaceShape::kColumn),
            (std::vector<SampleSet>{{0, 2, 3, 4}, {4}}));
}

class RandomPartitions : public ::testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Seeds, RandomPartitions, ::testing::Range(1U, 6U));

TEST_P(RandomPartitions, SplittingARegionNeverRaisesRecallNorTotalPrecisionsLoss) {
  std::mt19937 random(GetParam());
  std::uniform_int_distribution<int> draw_room(-1, 3);
  std::uniform_int_distribution<std::size_t> draw_region(0, 4);
  std::vector<int> room_of_samples;
  std::vector<SampleSet> regions(5);
  for (std::size_t i = 0; i < 300; ++i) {
    room_of_samples.push_back(draw_room(random));
    regions[draw_region(random)].push_back(i);
  }
  const auto score = [&](const std::vector<SampleSet>& sets) {
    return computeRegionScores(computeOverlaps(room_of_samples, 4, sets, true));
  };
  std::vector<SampleSet> split = regions;
  const auto middle = static_cast<std::ptrdiff_t>(split[0].size() / 2);
  split.emplace_back(split[0].begin() + middle, split[0].end());
  split[0].resize(static_cast<std::size_t>(middle));
  EXPECT_LE(score(split).recall, score(regions).recall + kTolerance);
  EXPECT_GE(score(split).total_precision, score(regions).total_precision - kTolerance);
}

}  // namespace
}  // namespace tsg::evaluation
