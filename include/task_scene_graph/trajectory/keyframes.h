// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/core/trajectory.h"
#include "task_scene_graph/trajectory/pose_graph.h"

namespace tsg::trajectory {

struct KeyframeConfig {
  double distance_m = 0.5;
  double angle_rad = 0.5;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("distance_m", self.distance_m, {0.01, 100.0}, "m",
            "a pose so far from the last keyframe is the next one");
    v.field("angle_rad", self.angle_rad, {0.01, 3.2}, "rad", "... or turned so far");
  }
};

/// How fast odometry drifts: deviations of each coordinate and each angle after 1 m of way, or a
/// turn of 1 rad; they grow with the root of both together. As given: 1 % and half a degree after
/// 10 m, besides the bias that a graph may allow for.
struct OdometryNoise {
  double position_m = 0.03;
  double angle_rad = 0.003;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("position_m", self.position_m, {1e-6, 10.0}, "m",
            "deviation of each coordinate after 1 m of way or a turn of 1 rad");
    v.field("angle_rad", self.angle_rad, {1e-6, 3.0}, "rad", "deviation of each angle after that");
  }
};

/// A moment of the trajectory that a map hangs on.
struct Keyframe {
  KeyframeId id;
  Stamp stamp;
  Pose T_world_camera = Pose::Identity();
};

/// What hangs on which keyframes, and how much: ascending by id, shares above 0 that sum to 1.
using Anchors = std::vector<std::pair<KeyframeId, double>>;

/// The keyframes of one pass, ascending by id and by stamp: a value. Not thread-safe.
class Keyframes {
 public:
  /// @param frame  in which the poses are
  /// @throws config::ConfigError naming every value out of range.
  explicit Keyframes(std::string frame, const KeyframeConfig& config = {});

  const std::string& frame() const { return frame_; }
  const std::vector<Keyframe>& list() const { return list_; }
  bool isEmpty() const { return list_.empty(); }
  /// Null if there is none. O(log keyframes).
  const Keyframe* find(KeyframeId id) const;

  /// The camera's next pose: a keyframe if it is the first, or far or turned enough from the last
  /// keyframe. @returns its id, those ascend from 1 by 1; none if it is no keyframe.
  /// @throws std::invalid_argument naming the stamp if it is not after the last keyframe's, or if
  /// the pose is not finite or not rigid; nothing has changed then.
  std::optional<KeyframeId> add(Stamp stamp, const Pose& T_world_camera);

  /// A keyframe, however near to the last one. @returns, throws as add().
  KeyframeId append(Stamp stamp, const Pose& T_world_camera);

  /// The same keyframes at other poses. @throws std::invalid_argument unless there are as many.
  Keyframes withPoses(const std::vector<Pose>& T_world_camera) const;

  /// What was seen at a stamp hangs on the keyframes before and after, by time; on the first or
  /// last before or after all. There must be a keyframe. O(log keyframes).
  Anchors anchorsAt(Stamp stamp) const;

 private:
  void requireNext(Stamp stamp, const Pose& T_world_camera) const;

  std::string frame_;
  KeyframeConfig config_;
  std::vector<Keyframe> list_;
};

/// The keyframes of a whole trajectory. O(poses). @throws as Keyframes.
Keyframes selectKeyframes(const Trajectory& trajectory, std::string frame,
                          const KeyframeConfig& config = {});

/// The motion from one keyframe to the next, as sure as the noise says of its way and turn; never
/// surer than after 1 cm.
PoseEdge makeOdometryEdge(const Keyframe& a, const Keyframe& b, const OdometryNoise& noise);

/// The pose graph of the keyframes, each joined to the next by the motion between them. Its poses
/// are theirs, but for rounding.
PoseGraph makePoseGraph(const Keyframes& keyframes, const OdometryNoise& noise,
                        const PoseGraphConfig& config = {});

}  // namespace tsg::trajectory
