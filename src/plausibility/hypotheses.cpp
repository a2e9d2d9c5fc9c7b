// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>

#include "reprojection.h"

namespace tsg::plausibility {
namespace {

using Kind = Hypothesis::Kind;

constexpr std::array<double, 20> kDepthFactors{0.001, 0.002, 0.005, 0.01, 0.02,  0.05,  0.1,
                                               0.2,   0.25,  0.4,   0.6,  1.6,   2.5,   4.0,
                                               5.0,   10.0,  20.0,  50.0, 200.0, 1000.0};
constexpr std::array<double, 8> kFocalFactors{0.5, 0.58, 0.67, 0.77, 1.3, 1.5, 1.73, 2.0};
constexpr std::array<double, 8> kDelays_s{0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5};

constexpr std::array<double, 6> kTilts_deg{-45.0, -30.0, -15.0, 15.0, 30.0, 45.0};

/// The 24 rotations that map axes to axes; the identity first.
std::vector<Eigen::Matrix3d> makeAxisRotations() {
  std::vector<Eigen::Matrix3d> rotations;
  std::array<int, 3> order{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Eigen::Matrix3d R = Eigen::Matrix3d::Zero();
      for (int i = 0; i < 3; ++i) {
        R(order[static_cast<std::size_t>(i)], i) = (signs >> i & 1) != 0 ? -1.0 : 1.0;
      }
      if (R.determinant() > 0.0) rotations.push_back(R);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return rotations;
}

Hypothesis makeAxes(const Eigen::Matrix3d& R_given_true, bool is_inverse) {
  Hypothesis hypothesis;
  hypothesis.kind = is_inverse ? Kind::kInverseAxes : Kind::kAxes;
  hypothesis.R_given_true = R_given_true;
  hypothesis.is_inverse = is_inverse;
  if (R_given_true.isIdentity()) hypothesis.kind = is_inverse ? Kind::kInverse : Kind::kGiven;
  return hypothesis;
}

void addTilted(std::vector<Hypothesis>& list) {
  for (const double tilt_deg : kTilts_deg) {
    Hypothesis hypothesis;
    hypothesis.kind = Kind::kTilted;
    const Eigen::AngleAxisd tilt(tilt_deg * 3.14159265358979323846 / 180.0,
                                 Eigen::Vector3d::UnitX());
    hypothesis.R_given_true = tilt.toRotationMatrix();
    list.push_back(hypothesis);
  }
}

void addMirrored(std::vector<Hypothesis>& list) {
  for (int axis = 0; axis < 3; ++axis) {
    Hypothesis hypothesis;
    hypothesis.kind = Kind::kMirrored;
    hypothesis.R_given_true(axis, axis) = -1.0;
    list.push_back(hypothesis);
  }
}

void addGeometry(std::vector<Hypothesis>& list) {
  Hypothesis hypothesis;
  hypothesis.kind = Kind::kDepthScale;
  for (const double factor : kDepthFactors) {
    hypothesis.depth_factor = factor;
    list.push_back(hypothesis);
  }
  hypothesis = {};
  hypothesis.kind = Kind::kFocalLength;
  for (const double factor : kFocalFactors) {
    hypothesis.focal_factor = factor;
    list.push_back(hypothesis);
  }
  hypothesis = {};
  hypothesis.kind = Kind::kRayDistance;
  list.push_back(hypothesis);
}

void addDelays(std::vector<Hypothesis>& list) {
  Hypothesis hypothesis;
  hypothesis.kind = Kind::kDelay;
  for (const double delay_s : kDelays_s) {
    for (const double sign : {1.0, -1.0}) {
      hypothesis.delay_s = sign * delay_s;
      list.push_back(hypothesis);
    }
  }
}

}  // namespace

Eigen::Matrix3d openglAxes() { return Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal(); }

Eigen::Matrix3d bodyAxes() {
  Eigen::Matrix3d R_body_optical;
  R_body_optical << 0.0, 0.0, 1.0,  //
      -1.0, 0.0, 0.0,               //
      0.0, -1.0, 0.0;
  return R_body_optical;
}

Pose computeRelativePose(const Hypothesis& hypothesis, const Pose& T_world_target,
                         const Pose& T_world_source) {
  if (hypothesis.kind == Kind::kStandstill) return Pose::Identity();
  const Pose T = hypothesis.is_inverse ? T_world_target * T_world_source.inverse(Eigen::Isometry)
                                       : T_world_target.inverse(Eigen::Isometry) * T_world_source;
  const Eigen::Matrix3d& R = hypothesis.R_given_true;
  Pose T_target_source = Pose::Identity();
  T_target_source.linear() = R.transpose() * T.linear() * R;
  T_target_source.translation() = R.transpose() * T.translation();
  return T_target_source;
}

std::vector<Hypothesis> makeSingleHypotheses() {
  std::vector<Hypothesis> list(2);
  list[1].kind = Kind::kStandstill;
  for (const bool is_inverse : {false, true}) {
    for (const Eigen::Matrix3d& R : makeAxisRotations()) {
      const Hypothesis hypothesis = makeAxes(R, is_inverse);
      if (hypothesis.kind != Kind::kGiven) list.push_back(hypothesis);
    }
  }
  addTilted(list);
  addMirrored(list);
  addGeometry(list);
  addDelays(list);
  return list;
}

std::vector<Hypothesis> makeDoubleHypotheses() {
  std::vector<Hypothesis> list(2);
  list[1].kind = Kind::kStandstill;
  for (const bool is_inverse : {false, true}) {
    for (const Eigen::Matrix3d& R :
         {Eigen::Matrix3d(Eigen::Matrix3d::Identity()), openglAxes(), bodyAxes()}) {
      if (!is_inverse && R.isIdentity()) continue;
      for (const double factor : kDepthFactors) {
        Hypothesis hypothesis = makeAxes(R, is_inverse);
        hypothesis.depth_factor = factor;
        list.push_back(hypothesis);
      }
    }
  }
  return list;
}

}  // namespace tsg::plausibility
