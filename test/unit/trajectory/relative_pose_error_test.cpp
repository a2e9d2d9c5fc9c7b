// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/relative_pose_error.h"

#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include <array>

#include "graph_worlds.h"

namespace tsg::trajectory {
namespace {

using Cost = ceres::AutoDiffCostFunction<RelativePoseError, 6, 3, 4, 3, 4>;

/// Positions and quaternions (x, y, z, w) of two poses, as the solver holds them.
struct Blocks {
  Blocks(const Pose& a, const Pose& b) {
    const Eigen::Quaterniond q_a(a.linear());
    const Eigen::Quaterniond q_b(b.linear());
    values << a.translation(), q_a.coeffs(), b.translation(), q_b.coeffs();
  }
  std::array<const double*, 4> pointers() const {
    return {values.data(), values.data() + 3, values.data() + 7, values.data() + 10};
  }
  Eigen::Matrix<double, 14, 1> values;
};

Vector6d evaluate(const Cost& cost, const Blocks& blocks) {
  Vector6d error;
  EXPECT_TRUE(cost.Evaluate(blocks.pointers().data(), error.data(), nullptr));
  return error;
}

/// 6 x 14, with respect to the blocks' numbers.
Eigen::Matrix<double, 6, 14> computeJacobian(const Cost& cost, const Blocks& blocks) {
  Eigen::Matrix<double, 6, 3, Eigen::RowMajor> by_p_a, by_p_b;
  Eigen::Matrix<double, 6, 4, Eigen::RowMajor> by_q_a, by_q_b;
  std::array<double*, 4> jacobians{by_p_a.data(), by_q_a.data(), by_p_b.data(), by_q_b.data()};
  Vector6d error;
  EXPECT_TRUE(cost.Evaluate(blocks.pointers().data(), error.data(), jacobians.data()));
  Eigen::Matrix<double, 6, 14> jacobian;
  jacobian << by_p_a, by_q_a, by_p_b, by_q_b;
  return jacobian;
}

Pose toPose(const Eigen::Matrix<double, 14, 1>& values, Eigen::Index first) {
  Pose pose = Pose::Identity();
  pose.linear() =
      Eigen::Quaterniond(Eigen::Vector4d(values.segment<4>(first + 3))).toRotationMatrix();
  pose.translation() = values.segment<3>(first);
  return pose;
}

Matrix6d makeRandomInformation(Noise& noise) {
  Matrix6d root;
  for (int i = 0; i < 6; ++i) root.col(i) = toVector(noise.draw(1.0, 0.5));
  return root * root.transpose() + 0.1 * Matrix6d::Identity();
}

TEST(RelativePoseError, ItsSquaredNormIsTheChi2OfTheEdge) {
  Noise noise(2);
  for (int i = 0; i < 50; ++i) {
    const Pose T_a = noise.draw(3.0, 1.0);
    const Pose T_b = noise.draw(3.0, 1.0);
    const PoseEdge edge =
        makeEdge(1, 2, noise.draw(3.0, 1.0), EdgeKind::kLoop, makeRandomInformation(noise));
    const Cost cost(new RelativePoseError(edge.T_a_b, edge.information, 0.25));
    const Vector6d error = computeError(edge, T_a, T_b);
    EXPECT_NEAR(evaluate(cost, Blocks(T_a, T_b)).squaredNorm(),
                0.25 * error.dot(edge.information * error), 1e-9 * error.squaredNorm());
  }
}

TEST(RelativePoseError, JacobiansAreThoseOfCentralDifferences) {
  Noise noise(3);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 50; ++i) {
    const Blocks at(noise.draw(3.0, 1.0), noise.draw(3.0, 1.0));
    const Cost cost(new RelativePoseError(noise.draw(3.0, 1.0), makeRandomInformation(noise), 1.0));
    const Eigen::Matrix<double, 6, 14> jacobian = computeJacobian(cost, at);
    for (Eigen::Index k = 0; k < 14; ++k) {
      Blocks above = at;
      Blocks below = at;
      above.values(k) += kStep;
      below.values(k) -= kStep;
      const Vector6d difference = (evaluate(cost, above) - evaluate(cost, below)) / (2.0 * kStep);
      EXPECT_LT((jacobian.col(k) - difference).norm(), 1e-6 * (1.0 + difference.norm()))
          << "column " << k;
    }
  }
}

// What the solver takes steps along: rotations q * exp(d) or exp(d) * q, never off the sphere.
TEST(RelativePoseError, AlongTurnsOfAPoseJacobiansAreThoseOfTheEdgesOwnError) {
  Noise noise(4);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 50; ++i) {
    const Blocks at(noise.draw(3.0, 1.0), noise.draw(3.0, 1.0));
    const PoseEdge edge = makeEdge(1, 2, noise.draw(3.0, 1.0));
    const Cost cost(new RelativePoseError(edge.T_a_b, edge.information, 1.0));
    const Eigen::Matrix<double, 6, 14> jacobian = computeJacobian(cost, at);
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::Quaterniond turn(1.0, 0.0, 0.0, 0.0);
      turn.vec()(axis) = 0.5;  // derivative of exp(d) by the angle d at 0, less the 1
      const Eigen::Quaterniond q(Eigen::Vector4d(at.values.segment<4>(3)));
      turn.w() = 0.0;
      const Vector6d along = jacobian.middleCols<4>(3) * (turn * q).coeffs();
      const auto turned = [&](double angle_rad) {
        Pose T = toPose(at.values, 0);
        T.linear() = Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::Unit(axis)) * T.linear();
        return computeError(edge, T, toPose(at.values, 7));
      };
      const Vector6d difference = (turned(kStep) - turned(-kStep)) / (2.0 * kStep);
      EXPECT_LT((along - difference).norm(), 1e-7 * (1.0 + difference.norm()));
    }
  }
}

TEST(BiasedPoseError, IsTheErrorOfTheCorrectedEdge) {
  using BiasedCost = ceres::AutoDiffCostFunction<BiasedPoseError, 6, 3, 4, 3, 4, 4>;
  Noise noise(31);
  PoseGraphConfig config;
  config.odometry_scale = 0.03;
  config.odometry_turn_rad_per_m = 0.02;
  for (int trial = 0; trial < 20; ++trial) {
    const Pose a = noise.draw(1.0, 0.8);
    const PoseEdge edge =
        makeEdge(1, 2, noise.draw(1.0, 0.8), EdgeKind::kOdometry, makeRandomInformation(noise));
    const Pose b = a * edge.T_a_b * noise.draw(0.1, 0.1);
    const Eigen::Vector4d units = toVector(noise.draw(1.0, 0.5)).head<4>();
    const OdometryBias bias{config.odometry_scale * units(0),
                            config.odometry_turn_rad_per_m * units.tail<3>()};
    const BiasedCost biased(new BiasedPoseError(edge, config, 0.7));
    const Blocks blocks(a, b);
    const auto four = blocks.pointers();
    const std::array<const double*, 5> five{four[0], four[1], four[2], four[3], units.data()};
    Vector6d error;
    ASSERT_TRUE(biased.Evaluate(five.data(), error.data(), nullptr));
    const Vector6d expected = computeBiasedError(edge.T_a_b, bias, a.inverse() * b);
    const double chi2 = 0.7 * expected.dot(edge.information * expected);
    EXPECT_NEAR(error.squaredNorm(), chi2, 1e-9 * (1.0 + chi2));
  }
}

}  // namespace
}  // namespace tsg::trajectory
