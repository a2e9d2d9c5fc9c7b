// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/trajectory/odometry_bias.h"

#include <gtest/gtest.h>

#include "graph_worlds.h"
#include "task_scene_graph/config/config.h"

namespace tsg::trajectory {
namespace {

PoseGraphConfig makeBiasedConfig() {
  PoseGraphConfig config;
  config.odometry_scale = 0.03;
  config.odometry_turn_rad_per_m = 0.003;
  return config;
}

OdometryBias makeBias() { return {0.02, Eigen::Vector3d(0.0, 0.0, 0.002)}; }

/// The world's laps, with odometry that the bias would correct, noise aside; and its loop closures.
PoseGraph makeBiasedLaps(const LapWorld& world, const PoseGraphConfig& config,
                         const OdometryBias& bias) {
  PoseGraph graph(config);
  graph.addKeyframe(KeyframeId{1}, world.truth[0]);
  for (PoseEdge edge : world.graph.edges()) {
    const OdometryBias inverse{1.0 / (1.0 + bias.scale) - 1.0,
                               -bias.turn_rad_per_m / (1.0 + bias.scale)};
    edge.T_a_b = correctOdometry(edge.T_a_b, inverse);
    graph.extend(edge);
  }
  for (const PoseEdge& loop : world.loops) graph.addEdge(loop);
  return graph;
}

double computeRmse(const LapWorld& world, const PoseGraph& graph) {
  LapWorld other{world.truth, graph, {}};
  return trajectory::computeRmse(other);
}

TEST(OdometryBias, OfZeroChangesNothing) {
  Noise noise(1);
  const Pose T = noise.draw(1.0, 0.5);
  EXPECT_TRUE(correctOdometry(T, {}).isApprox(T, 1e-12));
  EXPECT_FALSE(hasBias({}));
  EXPECT_TRUE(computeBiasJacobian(T, {}).isZero(0.0));
}

TEST(OdometryBias, JacobianIsThatOfDifferences) {
  Noise noise(2);
  const PoseGraphConfig config = makeBiasedConfig();
  constexpr double kStep = 1e-4;
  for (int trial = 0; trial < 20; ++trial) {
    const Pose T = noise.draw(1.0, 0.8);
    const auto jacobian = computeBiasJacobian(T, config);
    for (int i = 0; i < 4; ++i) {
      OdometryBias bias;
      if (i == 0) bias.scale = kStep * config.odometry_scale;
      if (i > 0) bias.turn_rad_per_m(i - 1) = kStep * config.odometry_turn_rad_per_m;
      const Vector6d moved = toVector(T.inverse() * correctOdometry(T, bias)) / kStep;
      EXPECT_TRUE(moved.isApprox(jacobian.col(i), 1e-5)) << moved.transpose();
    }
  }
}

/// Also loop closures between places 5 m apart: only these tell the scale.
LapWorld makeLapsSeenFromAfar(std::uint32_t seed) {
  LapWorld world = makeLaps(300, seed);
  Noise noise(seed + 100);
  constexpr std::size_t kLap = 120;
  constexpr std::size_t kAway = 10;
  for (std::size_t i = kLap + kAway; i < world.truth.size(); i += 5) {
    const std::size_t other = i - kLap - kAway;
    const Pose T = world.truth[i].inverse() * world.truth[other];
    world.loops.push_back(makeEdge(i + 1, other + 1, T * noise.draw(kLoopSigma_m, kLoopSigma_rad),
                                   EdgeKind::kLoop, makeInformation(kLoopSigma_m, kLoopSigma_rad)));
  }
  return world;
}

TEST(OdometryBias, IsFoundWherePlacesAreSeenFromOthersAndTheTrajectoryIsBetterForIt) {
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    const LapWorld world = makeLapsSeenFromAfar(seed);
    PoseGraph with = makeBiasedLaps(world, makeBiasedConfig(), makeBias());
    PoseGraphConfig trusting;
    trusting.max_gate_chi2 = 1e9;
    PoseGraph without = makeBiasedLaps(world, trusting, makeBias());
    ASSERT_FALSE(with.optimize().isFault());
    ASSERT_FALSE(without.optimize().isFault());
    EXPECT_NEAR(with.odometryBias().scale, 0.02, 0.008) << seed;
    EXPECT_NEAR(with.odometryBias().turn_rad_per_m.z(), 0.002, 0.002) << seed;
    EXPECT_LT(computeRmse(world, with), 0.8 * computeRmse(world, without)) << seed;
    EXPECT_EQ(without.odometryBias().scale, 0.0);
  }
}

/// Laps close at any scale; a smaller one makes no noise smaller.
TEST(OdometryBias, WhereNothingTellsTheScaleItStaysNearNone) {
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    const LapWorld world = makeLaps(300, seed);
    PoseGraph graph = makeBiasedLaps(world, makeBiasedConfig(), makeBias());
    ASSERT_FALSE(graph.optimize().isFault());
    EXPECT_NEAR(graph.odometryBias().scale, 0.0, 0.006) << seed;
  }
}

TEST(OdometryBias, IsInWhatTheGraphSaysOfItsEdgesAndInWhatFollows) {
  const LapWorld world = makeLaps(200, 4);
  PoseGraph graph = makeBiasedLaps(world, makeBiasedConfig(), makeBias());
  const SolveReport report = graph.optimize();
  ASSERT_EQ(report.status, SolveStatus::kSolved);
  EXPECT_LT(report.chi2_after, report.chi2_before);
  EXPECT_NEAR(report.chi2_after, graph.computeChi2(), 1e-9);
  const Pose last = graph.keyframes().back().T_world_keyframe;
  const PoseEdge next = makeEdge(200, 201, makePose(1.0, 0.0, 0.0));
  graph.extend(next);
  const Pose expected = last * correctOdometry(next.T_a_b, graph.odometryBias());
  EXPECT_TRUE(graph.keyframes().back().T_world_keyframe.isApprox(expected, 1e-12));
  EXPECT_FALSE(expected.isApprox(last * next.T_a_b, 1e-6));
}

/// The gate's covariance in closed form: along a straight line the scale's deviation grows with the
/// way, a random walk's with its root.
TEST(OdometryBias, LetsTheCheckAgainstOdometryAllowForIt) {
  constexpr int kSteps = 100;
  constexpr double kSigma_m = 0.01;
  const double limit_m = std::sqrt(PoseGraphConfig{}.max_gate_chi2 *
                                   (kSteps * kSigma_m * kSigma_m + 3.0 * 3.0 + 0.03 * 0.03));
  for (const auto& [share, verdict] :
       {std::make_pair(0.98, Verdict::kBelieved), {1.02, Verdict::kOdometryContradicts}}) {
    PoseGraph graph(makeBiasedConfig());
    graph.addKeyframe(KeyframeId{1}, Pose::Identity());
    for (std::uint64_t i = 1; i <= kSteps; ++i) {
      graph.extend(makeEdge(i, i + 1, makePose(1.0, 0.0, 0.0), EdgeKind::kOdometry,
                            makeInformation(kSigma_m, 1e-5)));
    }
    graph.addEdge(makeEdge(1, kSteps + 1, makePose(100.0 + share * limit_m, 0.0, 0.0),
                           EdgeKind::kLoop, makeInformation(0.03, 0.01)));
    ASSERT_FALSE(graph.optimize().isFault());
    EXPECT_EQ(graph.verdicts().back(), verdict);
  }
}

TEST(OdometryBias, AFaultLeavesItAsItWas) {
  const LapWorld world = makeLaps(200, 5);
  PoseGraphConfig config = makeBiasedConfig();
  config.max_iterations = 1;
  PoseGraph graph = makeBiasedLaps(world, config, makeBias());
  EXPECT_TRUE(graph.optimize().isFault());
  EXPECT_EQ(graph.odometryBias().scale, 0.0);
  EXPECT_TRUE(graph.odometryBias().turn_rad_per_m.isZero(0.0));
  config.odometry_scale = -1.0;
  EXPECT_THROW(PoseGraph{config}, config::ConfigError);
}

}  // namespace
}  // namespace tsg::trajectory
