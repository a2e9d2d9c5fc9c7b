// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/trajectory/pose_graph.h"

#include <gtest/gtest.h>

#include <limits>

#include "graph_worlds.h"
#include "task_scene_graph/config/config.h"

namespace tsg::trajectory {
namespace {

/// Loops believed whatever they say: for graphs whose optimum is known.
PoseGraphConfig makeTrustingConfig() {
  PoseGraphConfig config;
  config.max_loop_chi2 = 1e6;
  config.max_gate_chi2 = 1e12;
  config.max_odometry_chi2 = 1e12;
  return config;
}

/// Keyframes 1 to n, from each to the next the same motion by odometry.
PoseGraph makeChain(std::uint64_t n, const Pose& T, const Matrix6d& information,
                    const PoseGraphConfig& config = makeTrustingConfig()) {
  PoseGraph graph(config);
  graph.addKeyframe(KeyframeId{1}, Pose::Identity());
  for (std::uint64_t i = 1; i < n; ++i) {
    graph.extend(makeEdge(i, i + 1, T, EdgeKind::kOdometry, information));
  }
  return graph;
}

Eigen::Vector3d positionOf(const PoseGraph& graph, std::uint64_t id) {
  return graph.find(KeyframeId{id})->T_world_keyframe.translation();
}

TEST(PoseGraph, ExtendingPutsKeyframesWhereOdometrySays) {
  PoseGraph graph = makeChain(5, makePose(1.0, 0.0, 0.0, kPi / 2.0), Matrix6d::Identity());
  EXPECT_LT((positionOf(graph, 4) - Eigen::Vector3d(0.0, 1.0, 0.0)).norm(), 1e-12);
  EXPECT_LT(positionOf(graph, 5).norm(), 1e-12);
  EXPECT_EQ(graph.optimize().status, SolveStatus::kUnchanged);
  EXPECT_NEAR(graph.computeChi2(), 0.0, 1e-20);
}

// Springs in a row: the mismatch is shared by their variances.
TEST(PoseGraph, AMismatchOfOneCoordinateIsSharedByVariance) {
  PoseGraph graph(makeTrustingConfig());
  graph.addKeyframe(KeyframeId{1}, Pose::Identity());
  const double variances[] = {0.01, 0.04, 0.02};
  for (std::uint64_t i = 1; i <= 3; ++i) {
    graph.extend(makeEdge(i, i + 1, makePose(1.0, 0.0, 0.0), EdgeKind::kOdometry,
                          Matrix6d::Identity() / variances[i - 1]));
  }
  graph.addEdge(
      makeEdge(1, 4, makePose(3.3, 0.0, 0.0), EdgeKind::kLoop, Matrix6d::Identity() / 0.03));
  const SolveReport report = graph.optimize();
  ASSERT_EQ(report.status, SolveStatus::kSolved) << report.message;
  EXPECT_NEAR(report.chi2_before, 0.09 / 0.03, 1e-9);
  EXPECT_NEAR(report.chi2_after, 0.09 / 0.1, 1e-9);
  EXPECT_NEAR(positionOf(graph, 2).x(), 1.03, 1e-7);
  EXPECT_NEAR(positionOf(graph, 3).x(), 2.15, 1e-7);
  EXPECT_NEAR(positionOf(graph, 4).x(), 3.21, 1e-7);
}

TEST(PoseGraph, AMismatchOfTheHeadingIsSharedEvenly) {
  constexpr std::uint64_t kNum = 8;
  PoseGraph graph = makeChain(kNum, makePose(0.0, 0.0, 0.0, 0.2), Matrix6d::Identity());
  const double mismatch_rad = 0.4;
  graph.addEdge(
      makeEdge(1, kNum, makePose(0.0, 0.0, 0.0, 0.2 * (kNum - 1) + mismatch_rad), EdgeKind::kLoop));
  const SolveReport report = graph.optimize();
  ASSERT_EQ(report.status, SolveStatus::kSolved) << report.message;
  const double share = 2.0 * std::sin(mismatch_rad / kNum / 2.0);
  EXPECT_NEAR(report.chi2_after, kNum * share * share, 1e-9);
  const Pose last = graph.find(KeyframeId{kNum})->T_world_keyframe;
  EXPECT_NEAR(toVector(last)(5), 2.0 * std::sin((0.2 + mismatch_rad / kNum) * (kNum - 1) / 2.0),
              1e-5);
}

/// The sum of chi2, minimised by Gauss-Newton with a dense numeric Jacobian.
double minimiseByBruteForce(const PoseGraph& graph) {
  std::vector<Pose> poses;
  for (const auto& keyframe : graph.keyframes()) poses.push_back(keyframe.T_world_keyframe);
  const Eigen::Index num = 6 * static_cast<Eigen::Index>(poses.size() - 1);
  const auto moved = [&](const Eigen::VectorXd& step) {
    std::vector<Pose> result = poses;
    for (std::size_t i = 1; i < poses.size(); ++i) {
      const Vector6d d = step.segment<6>(6 * static_cast<Eigen::Index>(i - 1));
      result[i] = poses[i] * makePose(d(0), d(1), d(2), d.tail<3>().norm() + 1e-300,
                                      d.tail<3>() + Eigen::Vector3d::Constant(1e-300));
    }
    return result;
  };
  const auto residuals = [&](const std::vector<Pose>& at) {
    Eigen::VectorXd all(6 * static_cast<Eigen::Index>(graph.edges().size()));
    for (std::size_t i = 0; i < graph.edges().size(); ++i) {
      const PoseEdge& edge = graph.edges()[i];
      all.segment<6>(6 * static_cast<Eigen::Index>(i)) =
          edge.information.llt().matrixU() *
          computeError(edge, at[edge.a.value - 1], at[edge.b.value - 1]);
    }
    return all;
  };
  constexpr double kStep = 1e-6;
  for (int iteration = 0; iteration < 30; ++iteration) {
    const Eigen::VectorXd error = residuals(poses);
    Eigen::MatrixXd jacobian(error.size(), num);
    for (Eigen::Index k = 0; k < num; ++k) {
      const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(num, k);
      jacobian.col(k) = (residuals(moved(step)) - residuals(moved(-step))) / (2.0 * kStep);
    }
    poses = moved((jacobian.transpose() * jacobian).ldlt().solve(-jacobian.transpose() * error));
  }
  return residuals(poses).squaredNorm();
}

TEST(PoseGraph, RandomGraphsAreSolvedAsWellAsByBruteForce) {
  for (std::uint32_t seed = 0; seed < 5; ++seed) {
    Noise noise(seed);
    PoseGraph graph(makeTrustingConfig());
    graph.addKeyframe(KeyframeId{1}, noise.draw(1.0, 1.0));
    for (std::uint64_t i = 1; i < 8; ++i) {
      graph.extend(makeEdge(i, i + 1, noise.draw(1.0, 0.7), EdgeKind::kOdometry,
                            makeInformation(0.1, 0.05)));
    }
    using Ids = std::pair<std::uint64_t, std::uint64_t>;
    for (const auto& [a, b] : {Ids{1, 8}, Ids{3, 6}, Ids{7, 2}}) {
      const Pose T = graph.find(KeyframeId{a})->T_world_keyframe.inverse() *
                     graph.find(KeyframeId{b})->T_world_keyframe;
      graph.addEdge(
          makeEdge(a, b, T * noise.draw(0.3, 0.15), EdgeKind::kLoop, makeInformation(0.2, 0.1)));
    }
    const double expected = minimiseByBruteForce(graph);
    const SolveReport report = graph.optimize();
    ASSERT_EQ(report.status, SolveStatus::kSolved) << report.message;
    EXPECT_LT(report.chi2_after, report.chi2_before);
    EXPECT_GT(expected, 0.1);
    EXPECT_NEAR(report.chi2_after, expected, 1e-6 * expected) << "seed " << seed;
  }
}

TEST(PoseGraph, ARightLoopClosureTakesAwayMostOfTheDrift) {
  for (std::uint32_t seed = 0; seed < 5; ++seed) {
    LapWorld world = makeLaps(240, seed);
    const double before_m = computeRmse(world);
    for (const PoseEdge& loop : world.loops) world.graph.addEdge(loop);
    const SolveReport report = world.graph.optimize();
    ASSERT_EQ(report.status, SolveStatus::kSolved) << report.message;
    EXPECT_EQ(report.num_rejected, 0);
    EXPECT_LT(computeRmse(world), before_m) << "seed " << seed;
    // 6 degrees of freedom each: honest information gives a chi2 of about that.
    const double freedom = 6.0 * static_cast<double>(world.loops.size());
    EXPECT_NEAR(report.chi2_after, freedom, 5.0 * std::sqrt(2.0 * freedom)) << "seed " << seed;
  }
}

TEST(PoseGraph, OneByOneOrAllAtOnceTheSolutionIsTheSame) {
  LapWorld at_once = makeLaps(240, 7);
  PoseGraph one_by_one = at_once.graph;
  for (const PoseEdge& loop : at_once.loops) {
    at_once.graph.addEdge(loop);
    one_by_one.addEdge(loop);
    ASSERT_EQ(one_by_one.optimize().status, SolveStatus::kSolved);
  }
  ASSERT_EQ(at_once.graph.optimize().status, SolveStatus::kSolved);
  EXPECT_LT(computeLargestDifference(at_once.graph, one_by_one), 1e-3);
  EXPECT_NEAR(at_once.graph.computeChi2(), one_by_one.computeChi2(), 1e-4);
}

TEST(PoseGraph, TheWorldFrameIsFreeToChoose) {
  LapWorld world = makeLaps(150, 8);
  const Pose T = makePose(5.0, -3.0, 2.0, 1.0, {1.0, 2.0, 3.0});
  PoseGraph moved;
  moved.addKeyframe(KeyframeId{1}, T * world.truth[0]);
  for (const PoseEdge& edge : world.graph.edges()) moved.extend(edge);
  for (const PoseEdge& loop : world.loops) {
    world.graph.addEdge(loop);
    moved.addEdge(loop);
  }
  world.graph.optimize();
  moved.optimize();
  for (const GraphKeyframe& keyframe : world.graph.keyframes()) {
    EXPECT_TRUE(
        moved.find(keyframe.id)->T_world_keyframe.isApprox(T * keyframe.T_world_keyframe, 1e-4));
  }
}

TEST(PoseGraph, TheFirstKeyframeOfEachPartStaysWhereItIs) {
  PoseGraph graph = makeChain(4, makePose(1.0, 0.0, 0.0), Matrix6d::Identity());
  graph.addKeyframe(KeyframeId{11}, makePose(0.0, 50.0, 0.0, 1.0));
  graph.extend(makeEdge(11, 12, makePose(1.0, 0.0, 0.0)));
  graph.extend(makeEdge(12, 13, makePose(1.0, 0.0, 0.0)));
  graph.addEdge(makeEdge(1, 4, makePose(3.3, 0.0, 0.0), EdgeKind::kLoop));
  graph.addEdge(makeEdge(11, 13, makePose(2.3, 0.0, 0.0), EdgeKind::kLoop));
  const PoseGraph before = graph;
  ASSERT_EQ(graph.optimize().status, SolveStatus::kSolved);
  for (const std::uint64_t id : {1, 11}) {
    EXPECT_EQ(graph.find(KeyframeId{id})->T_world_keyframe.matrix(),
              before.find(KeyframeId{id})->T_world_keyframe.matrix());
  }
  EXPECT_NEAR((positionOf(graph, 13) - positionOf(graph, 11)).norm(), 2.2, 1e-6);
}

TEST(PoseGraph, ALoopClosureJoinsPartsWithoutBendingThem) {
  PoseGraph graph = makeChain(3, makePose(1.0, 0.0, 0.0), Matrix6d::Identity(), {});
  graph.addKeyframe(KeyframeId{11}, makePose(7.0, 50.0, 0.0, 1.0));
  graph.extend(makeEdge(11, 12, makePose(1.0, 0.0, 0.0)));
  graph.addEdge(makeEdge(3, 11, makePose(0.0, 1.0, 0.0), EdgeKind::kLoop));
  const SolveReport report = graph.optimize();
  ASSERT_EQ(report.status, SolveStatus::kSolved) << report.message;
  EXPECT_NEAR(report.chi2_after, 0.0, 1e-9);
  EXPECT_LT((positionOf(graph, 12) - Eigen::Vector3d(3.0, 1.0, 0.0)).norm(), 1e-4);
}

// Faults: what was there stays, and the reason is said.

void expectSame(const PoseGraph& a, const PoseGraph& b) {
  EXPECT_EQ(computeLargestDifference(a, b), 0.0);
  EXPECT_EQ(a.keyframes().size(), b.keyframes().size());
  EXPECT_EQ(a.edges().size(), b.edges().size());
  EXPECT_EQ(a.verdicts(), b.verdicts());
}

template <typename Action>
void expectRejected(PoseGraph& graph, const std::string& expected, const Action& action) {
  const PoseGraph before = graph;
  try {
    action();
    ADD_FAILURE() << "nothing was thrown, expected: " << expected;
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
  }
  expectSame(graph, before);
}

TEST(PoseGraph, WhatIsNoPoseOrNoInformationIsRejectedByName) {
  PoseGraph graph = makeChain(3, makePose(1.0, 0.0, 0.0), Matrix6d::Identity());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expectRejected(graph, "keyframe 9 has the pose",
                 [&] { graph.addKeyframe(KeyframeId{9}, makePose(nan, 0.0, 0.0)); });
  expectRejected(graph, "keyframe 2 is there already",
                 [&] { graph.addKeyframe(KeyframeId{2}, Pose::Identity()); });
  expectRejected(graph, "id 0", [&] { graph.addKeyframe(KeyframeId{}, Pose::Identity()); });
  expectRejected(graph, "the edge from keyframe 3 to keyframe 4 has the pose",
                 [&] { graph.extend(makeEdge(3, 4, makePose(0.0, nan, 0.0))); });
  expectRejected(graph, "names keyframe 8, which is not there",
                 [&] { graph.addEdge(makeEdge(1, 8, Pose::Identity())); });
  expectRejected(graph, "leads nowhere", [&] { graph.addEdge(makeEdge(2, 2, Pose::Identity())); });
  Matrix6d information = Matrix6d::Identity();
  information(5, 5) = -1.0;
  expectRejected(graph, "positive definite", [&] {
    graph.addEdge(makeEdge(1, 3, Pose::Identity(), EdgeKind::kLoop, information));
  });
  information(5, 5) = nan;
  expectRejected(graph, "positive definite", [&] {
    graph.extend(makeEdge(3, 4, Pose::Identity(), EdgeKind::kOdometry, information));
  });
  expectRejected(graph, "is no odometry",
                 [&] { graph.extend(makeEdge(3, 4, Pose::Identity(), EdgeKind::kLoop)); });
}

TEST(PoseGraph, AConfigurationOutOfRangeIsRejected) {
  PoseGraphConfig config;
  config.max_iterations = 0;
  EXPECT_THROW(PoseGraph{config}, config::ConfigError);
}

TEST(PoseGraph, WhereTheSolverDoesNotConvergeNothingMoves) {
  PoseGraphConfig config = makeTrustingConfig();
  config.max_iterations = 1;
  PoseGraph graph = makeChain(20, makePose(1.0, 0.0, 0.0, 0.3), makeInformation(0.01, 0.3), config);
  graph.addEdge(
      makeEdge(20, 1, makePose(-3.0, 2.0, 0.0, 2.0), EdgeKind::kLoop, makeInformation(0.01, 0.01)));
  const PoseGraph before = graph;
  const SolveReport report = graph.optimize();
  EXPECT_EQ(report.status, SolveStatus::kNotConverged);
  EXPECT_TRUE(report.isFault());
  EXPECT_NE(report.message.find("max_iterations 1"), std::string::npos) << report.message;
  expectSame(graph, before);
}

TEST(PoseGraph, WhereTheCostIsNotFiniteNothingMoves) {
  PoseGraph graph = makeChain(3, makePose(1e160, 0.0, 0.0), Matrix6d::Identity());
  graph.addEdge(makeEdge(1, 3, makePose(-1e160, 0.0, 0.0), EdgeKind::kLoop));
  const PoseGraph before = graph;
  const SolveReport report = graph.optimize();
  EXPECT_TRUE(report.isFault());
  EXPECT_FALSE(report.message.empty());
  expectSame(graph, before);
}

TEST(PoseGraph, OdometryThatContradictsItselfIsReportedAndNothingMoves) {
  PoseGraph graph = makeChain(4, makePose(1.0, 0.0, 0.0), makeInformation(0.01, 0.01), {});
  graph.addEdge(
      makeEdge(2, 3, makePose(2.0, 0.0, 0.0), EdgeKind::kOdometry, makeInformation(0.01, 0.01)));
  const PoseGraph before = graph;
  const SolveReport report = graph.optimize();
  EXPECT_EQ(report.status, SolveStatus::kContradiction);
  EXPECT_NE(report.message.find("from keyframe 2 to 3 by a chi2 of 2500"), std::string::npos)
      << report.message;
  expectSame(graph, before);
}

}  // namespace
}  // namespace tsg::trajectory
