// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "task_scene_graph/trajectory/pose_graph.h"

namespace tsg::trajectory {

constexpr double kPi = 3.14159265358979323846;

inline Pose makePose(double x_m, double y_m, double z_m, double angle_rad = 0.0,
                     const Eigen::Vector3d& axis = Eigen::Vector3d::UnitZ()) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(angle_rad, axis.normalized()).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(x_m, y_m, z_m);
  return pose;
}

inline Matrix6d makeInformation(double sigma_m, double sigma_rad) {
  Vector6d diagonal;
  diagonal << Eigen::Vector3d::Constant(1.0 / (sigma_m * sigma_m)),
      Eigen::Vector3d::Constant(1.0 / (sigma_rad * sigma_rad));
  return diagonal.asDiagonal();
}

inline PoseEdge makeEdge(std::uint64_t a, std::uint64_t b, const Pose& T_a_b,
                         EdgeKind kind = EdgeKind::kOdometry,
                         const Matrix6d& information = Matrix6d::Identity()) {
  return {KeyframeId{a}, KeyframeId{b}, T_a_b, information, kind};
}

/// Motions with the given deviation of each coordinate.
class Noise {
 public:
  explicit Noise(std::uint32_t seed) : engine_(seed) {}

  Pose draw(double sigma_m, double sigma_rad) {
    const Eigen::Vector3d t(normal_(engine_), normal_(engine_), normal_(engine_));
    const Eigen::Vector3d r(normal_(engine_), normal_(engine_), normal_(engine_));
    const double angle_rad = sigma_rad * r.norm();
    const Eigen::Vector3d p_m = sigma_m * t;
    return makePose(p_m.x(), p_m.y(), p_m.z(), angle_rad, r);
  }
  std::uint64_t drawId(std::uint64_t largest) {
    return std::uniform_int_distribution<std::uint64_t>(1, largest)(engine_);
  }

 private:
  std::mt19937 engine_;
  std::normal_distribution<double> normal_;
};

constexpr double kStep_m = 0.5;
constexpr double kOdometrySigma_m = 0.01;  // 2 % of a step
constexpr double kOdometrySigma_rad = 0.005;
constexpr double kLoopSigma_m = 0.03;
constexpr double kLoopSigma_rad = 0.01;

/// Laps around a block of 20 x 10 m with a ramp, walked with drift, and what was measured on them.
struct LapWorld {
  std::vector<Pose> truth;      ///< of keyframe i + 1
  PoseGraph graph;              ///< odometry only
  std::vector<PoseEdge> loops;  ///< right ones
};

inline Pose computeLapPose(int step) {
  constexpr int kLongSide = 40;
  constexpr int kShortSide = 20;
  constexpr int kLap = 2 * (kLongSide + kShortSide);
  int at = step % kLap;
  Pose pose = Pose::Identity();
  for (int side = 0; side < 4; ++side) {
    const int length = side % 2 == 0 ? kLongSide : kShortSide;
    const int steps = std::min(at, length);
    pose = pose * makePose(steps * kStep_m, 0.0, 0.0);
    at -= steps;
    if (at == 0 && steps < length) break;
    pose = pose * makePose(0.0, 0.0, 0.0, kPi / 2.0);
  }
  pose.translation().z() = std::sin(2.0 * kPi * (step % kLap) / kLap);
  return pose;
}

inline LapWorld makeLaps(int num_keyframes, std::uint32_t seed, int loop_period = 10) {
  LapWorld world;
  Noise noise(seed);
  const auto size = static_cast<std::size_t>(num_keyframes);
  for (int i = 0; i < num_keyframes; ++i) world.truth.push_back(computeLapPose(i));
  world.graph.addKeyframe(KeyframeId{1}, world.truth[0]);
  const Matrix6d odometry = makeInformation(kOdometrySigma_m, kOdometrySigma_rad);
  for (std::size_t i = 1; i < size; ++i) {
    const Pose T = world.truth[i - 1].inverse() * world.truth[i];
    world.graph.extend(makeEdge(i, i + 1, T * noise.draw(kOdometrySigma_m, kOdometrySigma_rad),
                                EdgeKind::kOdometry, odometry));
  }
  constexpr std::size_t kLap = 120;
  for (std::size_t i = kLap; i < size; i += static_cast<std::size_t>(loop_period)) {
    const Pose T = world.truth[i].inverse() * world.truth[i - kLap];
    world.loops.push_back(makeEdge(i + 1, i + 1 - kLap,
                                   T * noise.draw(kLoopSigma_m, kLoopSigma_rad), EdgeKind::kLoop,
                                   makeInformation(kLoopSigma_m, kLoopSigma_rad)));
  }
  return world;
}

/// Loop closures between keyframes that never saw the same: both are said to be at one place.
inline std::vector<PoseEdge> makeFalseLoops(std::size_t count, std::uint64_t num_keyframes,
                                            std::uint32_t seed) {
  std::vector<PoseEdge> loops;
  Noise noise(seed);
  while (loops.size() < count) {
    const std::uint64_t a = noise.drawId(num_keyframes);
    const std::uint64_t b = noise.drawId(num_keyframes);
    const double apart_m = (computeLapPose(static_cast<int>(a) - 1).translation() -
                            computeLapPose(static_cast<int>(b) - 1).translation())
                               .norm();
    if (apart_m < 3.0) continue;
    loops.push_back(makeEdge(a, b, noise.draw(0.3, 0.2), EdgeKind::kLoop,
                             makeInformation(kLoopSigma_m, kLoopSigma_rad)));
  }
  return loops;
}

/// Root of the mean squared distance to the truth.
inline double computeRmse(const LapWorld& world) {
  double sum = 0.0;
  for (std::size_t i = 0; i < world.truth.size(); ++i) {
    sum +=
        (world.graph.keyframes()[i].T_world_keyframe.translation() - world.truth[i].translation())
            .squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(world.truth.size()));
}

/// Largest difference of any entry of any pose's matrix; infinite if the ids differ.
inline double computeLargestDifference(const PoseGraph& a, const PoseGraph& b) {
  double largest = 0.0;
  for (const GraphKeyframe& keyframe : a.keyframes()) {
    const GraphKeyframe* other = b.find(keyframe.id);
    if (other == nullptr) return std::numeric_limits<double>::infinity();
    largest =
        std::max(largest, (keyframe.T_world_keyframe.matrix() - other->T_world_keyframe.matrix())
                              .cwiseAbs()
                              .maxCoeff());
  }
  return largest;
}

}  // namespace tsg::trajectory
