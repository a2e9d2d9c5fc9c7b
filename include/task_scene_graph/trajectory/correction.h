// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "task_scene_graph/trajectory/keyframes.h"

namespace tsg::trajectory {

/// How what hangs on a keyframe moves, in world coordinates: p_new = T_new_old * p_old.
struct KeyframeMotion {
  KeyframeId id;
  Pose T_new_old = Pose::Identity();
};

/// The rigid motion between several, by their shares: dual quaternions, blended linearly and
/// normalised [DualQuat08]: it turns and shifts along the screw between two, does not
/// shrink what it moves, and does not depend on the choice of coordinates. All alike: that one, to
/// the bit.
/// @param motions  not empty; shares above 0 that sum to 1
Pose blend(const std::vector<std::pair<Pose, double>>& motions);

/// How each keyframe of a trajectory moved: a value, ascending by id.
class Correction {
 public:
  /// @throws std::invalid_argument naming the keyframe unless ids ascend and motions are rigid.
  explicit Correction(std::vector<KeyframeMotion> motions);

  const std::vector<KeyframeMotion>& motions() const { return motions_; }
  /// Nothing moves, to the bit.
  bool isIdentity() const;
  /// All keyframes move alike, to the bit.
  bool isRigid() const;

  /// O(anchors * log keyframes).
  /// @throws std::invalid_argument naming the keyframe if one is not there.
  Pose at(const Anchors& anchors) const;

 private:
  std::vector<KeyframeMotion> motions_;
};

/// By the poses of the same keyframes before and after. Keyframes whose poses are the same to the
/// bit have the identity.
/// @throws std::invalid_argument naming what differs: the frame, how many there are, an id or a
/// stamp.
Correction computeCorrection(const Keyframes& before, const Keyframes& after);

/// ... of a pose graph before and after it was solved. @throws std::invalid_argument as above.
Correction computeCorrection(const PoseGraph& before, const PoseGraph& after);

/// ... by another trajectory of the same camera in the same frame, as a SLAM system gives it.
/// Keyframes that lie before its first or after its last pose move as the nearest that does not.
/// @param max_gap_s  as Trajectory::interpolate()
/// @throws std::invalid_argument if the frames differ, a stamp lies in a longer gap, no keyframe
/// lies within, or a pose is not rigid.
Correction computeCorrection(const Keyframes& before, const Trajectory& corrected,
                             const std::string& corrected_frame, double max_gap_s);

/// All keyframes alike: a jump of the map's frame. @throws std::invalid_argument unless rigid.
Correction makeRigidCorrection(const Keyframes& keyframes, const Pose& T_new_old);

/// The keyframes where the correction puts them. @throws std::invalid_argument as
/// Correction::at().
Keyframes applyCorrection(const Correction& correction, const Keyframes& keyframes);

/// The camera's poses, each moved as what was seen at its stamp. O(poses * log keyframes).
/// @throws std::invalid_argument as Correction::at(), or if there is no keyframe.
Trajectory applyCorrection(const Correction& correction, const Keyframes& keyframes,
                           const Trajectory& trajectory);

}  // namespace tsg::trajectory
