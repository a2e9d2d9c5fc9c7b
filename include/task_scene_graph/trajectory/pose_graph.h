// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/core/id.h"
#include "task_scene_graph/trajectory/odometry_bias.h"
#include "task_scene_graph/trajectory/pose_graph_config.h"
#include "task_scene_graph/trajectory/se3.h"

namespace tsg::trajectory {

using KeyframeId = Id<struct KeyframeTag>;

enum class EdgeKind {
  kOdometry,  ///< always believed
  kLoop       ///< a place seen again: may be wrong
};

/// A measured pose of keyframe b in the frame of keyframe a.
struct PoseEdge {
  KeyframeId a;
  KeyframeId b;
  Pose T_a_b = Pose::Identity();
  /// Inverse covariance of computeError(), in b's frame as measured: 1 / m^2, 1 / rad^2.
  Matrix6d information = Matrix6d::Identity();
  EdgeKind kind = EdgeKind::kOdometry;
};

/// e = toVector(T_a_b^-1 * T_world_a^-1 * T_world_b): g2o's error of EDGE_SE3:QUAT, but for its
/// rotation, which is twice g2o's.
Vector6d computeError(const PoseEdge& edge, const Pose& T_world_a, const Pose& T_world_b);

/// Whether the configuration lets the edge have a bias.
inline bool isBiased(const PoseEdge& edge, const PoseGraphConfig& config) {
  return edge.kind == EdgeKind::kOdometry && hasBias(config);
}

/// As above, or computeBiasedError() of an edge that may have a bias.
Vector6d computeError(const PoseEdge& edge, const PoseGraphConfig& config, const OdometryBias& bias,
                      const Pose& T_world_a, const Pose& T_world_b);

/// What is thought of an edge.
enum class Verdict {
  kUndecided,             ///< new since the last solution
  kBelieved,              ///< odometry always is
  kOdometryContradicts,   ///< odometry cannot have drifted so far
  kOtherEdgesContradict,  ///< with it the others would not fit
};

struct GraphKeyframe {
  KeyframeId id;
  Pose T_world_keyframe = Pose::Identity();
};

enum class SolveStatus {
  kUnchanged,      ///< no edge is new, or those that are were rejected
  kSolved,         ///< the keyframes have moved
  kNotConverged,   ///< too many iterations
  kFailed,         ///< the solver found no finite step
  kContradiction,  ///< odometry would have to bend too far
};

/// What a call of PoseGraph::optimize() did. Keyframes move only with kSolved; with a fault
/// verdicts stay too.
struct SolveReport {
  SolveStatus status = SolveStatus::kUnchanged;
  std::string message;       ///< for people: why it was not solved
  double chi2_before = 0.0;  ///< of all edges believed in the end, where the keyframes were
  double chi2_after = 0.0;
  int num_believed = 0;    ///< loop closures
  int num_rejected = 0;    ///< loop closures
  int num_rounds = 0;      ///< solutions, from the plain one on
  int num_iterations = 0;  ///< of the solver, in all rounds

  bool isFault() const { return status > SolveStatus::kSolved; }
};

/// Keyframes and measured poses between them: a value. optimize() finds the poses T_world_keyframe
/// that minimise the sum of e^T Omega e over odometry and over those loop closures that can be true
/// together. Not thread-safe.
///
/// Loop closures are checked twice. First each alone against odometry: its chi2 under the
/// covariance of odometry on the way between both keyframes, added up by first order, and its own
/// [Kimera20]. What passes goes through graduated non-convexity with a truncated least
/// squares cost [GNC20, Eq. 14]: weights of loop closures from a convex cost, which
/// lets all of them pull, to the truncated one, which leaves out those that do not fit.
///
/// Where the configuration lets odometry have a bias, it is estimated with the poses, as four more
/// unknowns with deviations of their own; the check against odometry allows for it.
class PoseGraph {
 public:
  /// @throws config::ConfigError naming every value out of range.
  explicit PoseGraph(const PoseGraphConfig& config = {});

  const PoseGraphConfig& config() const { return config_; }
  const std::vector<GraphKeyframe>& keyframes() const { return keyframes_; }  ///< ascending by id
  const std::vector<PoseEdge>& edges() const { return edges_; }       ///< in the order of adding
  const std::vector<Verdict>& verdicts() const { return verdicts_; }  ///< one for each edge
  /// Of odometry, as the last solution found it; zero unless the configuration allows one.
  const OdometryBias& odometryBias() const { return bias_; }
  /// Null if there is none. O(log keyframes).
  const GraphKeyframe* find(KeyframeId id) const;

  /// A keyframe that nothing leads to yet. O(log keyframes) if its id is the largest.
  /// @throws std::invalid_argument naming the keyframe if its id is taken or 0, or the pose is not
  /// finite or not rigid; nothing has changed then, here and below.
  void addKeyframe(KeyframeId id, const Pose& T_world_keyframe);

  /// The keyframe `odometry.b`, put where the edge says from where `a` is now, less the bias.
  /// @throws std::invalid_argument as addKeyframe() and addEdge().
  void extend(const PoseEdge& odometry);

  /// @throws std::invalid_argument naming both keyframes if one is unknown, they are the same, the
  /// pose is not finite or not rigid, or the information is not symmetric and positive definite.
  void addEdge(const PoseEdge& edge);

  /// Solves from where the keyframes are now. The first keyframe of each connected part stays where
  /// it is. Nothing is solved while no edge is undecided: extend() moves nothing else. After a
  /// fault the edges are still there and undecided; to be rid of them, add them to a copy of the
  /// graph. O(keyframes + edges) for each iteration where loops are few; more where Cholesky fills
  /// in.
  SolveReport optimize();

  /// Sum of chi2 over the edges that are odometry or believed.
  double computeChi2() const;

 private:
  std::size_t indexOf(KeyframeId id) const;

  PoseGraphConfig config_;
  OdometryBias bias_;
  std::vector<GraphKeyframe> keyframes_;
  std::vector<PoseEdge> edges_;
  std::vector<Verdict> verdicts_;
};

}  // namespace tsg::trajectory
