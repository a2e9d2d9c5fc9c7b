// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/trajectory/keyframes.h"

namespace tsg::loops {

struct SupportConfig {
  double max_way_m = 6.0;
  double max_chi2 = 22.5;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("max_way_m", self.max_way_m, {0.0, 100.0}, "m",
            "a loop closure supports another if both its ends are so near to the other's, along "
            "the way; 0 = none is needed");
    v.field("max_chi2", self.max_chi2, {0.1, 1e6}, "",
            "... and both say the same, with the drift that odometry may have on that way");
  }
};

/// Whether two loop closures say the same: chi2 of the motion around the cycle a -> c -> d -> b ->
/// a, with the covariances of both loop closures and of odometry on the ways a to c and b to d,
/// each moved by its adjoint, and odometry's bias. That is pairwise consistency [PCM18] where
/// odometry is nearly exact: chance seldom passes it, while over a long way drift hides what is
/// wrong.
class LoopSupport {
 public:
  /// The keyframes, poses by odometry, must outlive this.
  /// @param bias  that odometry may have: its two deviations count only. @throws
  /// config::ConfigError
  LoopSupport(const trajectory::Keyframes& keyframes, const trajectory::OdometryNoise& noise,
              const SupportConfig& config, const trajectory::PoseGraphConfig& bias = {});

  bool doAgree(const trajectory::PoseEdge& x, const trajectory::PoseEdge& y) const;
  /// Any other loop closure agrees; a second one between the same keyframes does not count. O(all).
  bool isSupported(const trajectory::PoseEdge& edge,
                   const std::vector<trajectory::PoseEdge>& all) const;

 private:
  /// Way and turn between two keyframes along the trajectory, and the motion with its covariance,
  /// in b's frame.
  struct Leg {
    double way_m = 0.0;
    Pose T_a_b = Pose::Identity();
    trajectory::Matrix6d covariance = trajectory::Matrix6d::Zero();
  };
  Leg measure(trajectory::KeyframeId a, trajectory::KeyframeId b) const;

  const trajectory::Keyframes& keyframes_;
  trajectory::OdometryNoise noise_;
  SupportConfig config_;
  trajectory::PoseGraphConfig bias_;
};

}  // namespace tsg::loops
