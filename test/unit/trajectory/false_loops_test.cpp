// SPDX-License-Identifier: BSD-3-Clause
// Loop closures that are wrong.
#include <gtest/gtest.h>

#include "graph_worlds.h"

namespace tsg::trajectory {
namespace {

void addAll(const std::vector<PoseEdge>& edges, PoseGraph& graph) {
  for (const PoseEdge& edge : edges) graph.addEdge(edge);
}

/// Verdicts of the last `count` edges.
std::vector<Verdict> lastVerdicts(const PoseGraph& graph, std::size_t count) {
  return {graph.verdicts().end() - static_cast<std::ptrdiff_t>(count), graph.verdicts().end()};
}

std::size_t countBelieved(const std::vector<Verdict>& verdicts) {
  return static_cast<std::size_t>(std::count(verdicts.begin(), verdicts.end(), Verdict::kBelieved));
}

class FalseLoops : public testing::TestWithParam<std::uint32_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, FalseLoops, testing::Range(0U, 5U));

TEST_P(FalseLoops, ThirtyPercentOfThemMakeNothingWorse) {
  LapWorld without = makeLaps(360, GetParam(), 4);
  LapWorld with = without;
  const std::size_t count = without.loops.size() * 3 / 7;  // 30 % of all
  const auto wrong = makeFalseLoops(count, 360, GetParam() + 100);
  addAll(wrong, with.graph);
  addAll(with.loops, with.graph);
  addAll(without.loops, without.graph);
  ASSERT_EQ(without.graph.optimize().status, SolveStatus::kSolved);
  const SolveReport report = with.graph.optimize();
  ASSERT_EQ(report.status, SolveStatus::kSolved) << report.message;
  EXPECT_GE(report.num_believed, static_cast<int>(without.loops.size() * 98 / 100));
  EXPECT_LE(computeRmse(with), 1.02 * computeRmse(without));
}

// The gate against odometry left open: only the other loop closures can tell.
TEST_P(FalseLoops, WithoutTheGateTheOthersOutvoteThem) {
  LapWorld world = makeLaps(360, GetParam(), 4);
  PoseGraphConfig config;
  config.max_gate_chi2 = 1e12;
  PoseGraph without(config);
  without.addKeyframe(KeyframeId{1}, world.truth[0]);
  for (const PoseEdge& edge : world.graph.edges()) without.extend(edge);
  PoseGraph with = without;
  const auto wrong = makeFalseLoops(world.loops.size() * 3 / 7, 360, GetParam() + 200);
  addAll(world.loops, with);
  addAll(wrong, with);
  addAll(world.loops, without);
  ASSERT_EQ(without.optimize().status, SolveStatus::kSolved);
  const SolveReport report = with.optimize();
  ASSERT_EQ(report.status, SolveStatus::kSolved) << report.message;
  EXPECT_EQ(countBelieved(lastVerdicts(with, wrong.size())), 0U);
  EXPECT_LT(computeLargestDifference(with, without), 0.05);
}

TEST_P(FalseLoops, OneThatComesLaterMovesNothing) {
  LapWorld world = makeLaps(360, GetParam());
  addAll(world.loops, world.graph);
  ASSERT_EQ(world.graph.optimize().status, SolveStatus::kSolved);
  const PoseGraph before = world.graph;
  addAll(makeFalseLoops(1, 360, GetParam() + 300), world.graph);
  const SolveReport report = world.graph.optimize();
  EXPECT_EQ(report.status, SolveStatus::kUnchanged) << report.message;
  EXPECT_EQ(report.num_rejected, 1);
  EXPECT_EQ(computeLargestDifference(world.graph, before), 0.0);
}

TEST_P(FalseLoops, OneThatComesFirstIsOutvotedLater) {
  LapWorld world = makeLaps(360, GetParam());
  LapWorld without = world;
  PoseEdge wrong = world.loops[4];
  wrong.T_a_b = world.graph.find(wrong.a)->T_world_keyframe.inverse() *
                world.graph.find(wrong.b)->T_world_keyframe *
                makePose(0.3, 0.3, 0.0, 0.1);  // odometry may have drifted so far
  world.graph.addEdge(wrong);
  ASSERT_EQ(world.graph.optimize().num_believed, 1);
  for (const PoseEdge& loop : world.loops) {
    world.graph.addEdge(loop);
    world.graph.optimize();
  }
  addAll(without.loops, without.graph);
  without.graph.optimize();
  const std::size_t index = world.graph.edges().size() - world.loops.size() - 1;
  EXPECT_EQ(world.graph.verdicts()[index], Verdict::kOtherEdgesContradict);
  // One or the other may lie at the threshold.
  EXPECT_GE(countBelieved(lastVerdicts(world.graph, world.loops.size())) + 1,
            countBelieved(lastVerdicts(without.graph, world.loops.size())));
  EXPECT_LT(computeRmse(world), 1.05 * computeRmse(without));
}

TEST(FalseLoop, WhatOdometryCannotHaveDriftedIsRejectedEvenAlone) {
  LapWorld world = makeLaps(200, 1);
  const PoseGraph before = world.graph;
  world.graph.addEdge(makeEdge(1, 30, Pose::Identity(), EdgeKind::kLoop,
                               makeInformation(kLoopSigma_m, kLoopSigma_rad)));
  const SolveReport report = world.graph.optimize();
  EXPECT_EQ(report.status, SolveStatus::kUnchanged);
  EXPECT_EQ(world.graph.verdicts().back(), Verdict::kOdometryContradicts);
  EXPECT_EQ(computeLargestDifference(world.graph, before), 0.0);
}

// Chi2 against odometry alone, in closed form: the variances along the way add up.
TEST(FalseLoop, TheGateIsTheSumOfVariancesAlongTheWay) {
  constexpr std::uint64_t kNum = 26;
  PoseGraphConfig config;
  config.max_loop_chi2 = 1e6;
  PoseGraph graph(config);
  graph.addKeyframe(KeyframeId{1}, Pose::Identity());
  for (std::uint64_t i = 1; i < kNum; ++i) {  // 25 steps that cannot turn: 0.25 m^2 each way
    graph.extend(makeEdge(i, i + 1, makePose(1.0, 0.0, 0.0), EdgeKind::kOdometry,
                          makeInformation(0.1, 1e-6)));
  }
  const auto verdictOf = [&](std::uint64_t a, std::uint64_t b, double off_m) {
    PoseGraph copy = graph;
    const double way_m = static_cast<double>(b) - static_cast<double>(a);
    copy.addEdge(
        makeEdge(a, b, makePose(way_m, off_m, 0.0), EdgeKind::kLoop, makeInformation(1.0, 1.0)));
    copy.optimize();
    return copy.verdicts().back();
  };
  const double limit_m = std::sqrt(PoseGraphConfig{}.max_gate_chi2 * (0.25 + 1.0));
  for (const auto& [a, b] : {std::pair<std::uint64_t, std::uint64_t>{1, kNum}, {kNum, 1}}) {
    EXPECT_EQ(verdictOf(a, b, 0.999 * limit_m), Verdict::kBelieved);
    EXPECT_EQ(verdictOf(a, b, 1.001 * limit_m), Verdict::kOdometryContradicts);
  }
}

TEST(FalseLoop, OfTwoThatContradictEachOtherAlikeNeitherIsBelieved) {
  LapWorld world = makeLaps(200, 2);
  const PoseGraph before = world.graph;
  const PoseEdge& right = world.loops.back();
  for (const double off_m : {-0.4, 0.4}) {
    PoseEdge wrong = right;
    const Pose T_odometry =
        before.find(wrong.a)->T_world_keyframe.inverse() * before.find(wrong.b)->T_world_keyframe;
    wrong.T_a_b = T_odometry * makePose(0.0, 0.0, off_m);
    world.graph.addEdge(wrong);
  }
  const SolveReport report = world.graph.optimize();
  EXPECT_EQ(report.num_believed, 0) << report.message;
  EXPECT_EQ(lastVerdicts(world.graph, 2), std::vector<Verdict>(2, Verdict::kOtherEdgesContradict));
  EXPECT_EQ(computeLargestDifference(world.graph, before), 0.0);
}

}  // namespace
}  // namespace tsg::trajectory
