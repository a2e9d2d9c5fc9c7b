// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/trajectory/correction.h"

#include <algorithm>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "task_scene_graph/core/find_by_id.h"
#include "task_scene_graph/trajectory/se3.h"

namespace tsg::trajectory {
namespace {

bool isSame(const Pose& a, const Pose& b) { return a.matrix() == b.matrix(); }

std::string nameOf(KeyframeId id) { return "keyframe " + std::to_string(id.value); }

void requireRigid(KeyframeId id, const Pose& pose) {
  if (isRigid(pose)) return;
  throw std::invalid_argument(nameOf(id) +
                              " has a corrected pose that is not finite or no rotation");
}

template <typename Value>
void requireSame(const std::string& what, const Value& before, const Value& after) {
  if (before == after) return;
  std::ostringstream text;
  text << "the corrected trajectory has " << what << " " << after << ", expected " << before
       << " as before";
  throw std::invalid_argument(text.str());
}

/// The identity to the bit where nothing moved.
Pose computeMotion(const Pose& before, const Pose& after) {
  return isSame(before, after) ? Pose::Identity() : after * before.inverse();
}

Pose move(const Pose& pose, const Pose& motion) {
  return isSame(motion, Pose::Identity()) ? pose : motion * pose;
}

/// Nothing before the first or after the last pose.
std::optional<Pose> findPose(const Trajectory& corrected, const Keyframe& keyframe,
                             double max_gap_s) {
  const auto pose = corrected.interpolate(keyframe.stamp, max_gap_s);
  const double gap_s = corrected.gapAt(keyframe.stamp);
  if (pose) {
    requireRigid(keyframe.id, *pose);
  } else if (gap_s > 0.0) {
    std::ostringstream text;
    text << "the corrected trajectory has a gap of " << gap_s << " s at " << nameOf(keyframe.id)
         << ", expected at most " << max_gap_s << " s";
    throw std::invalid_argument(text.str());
  }
  return pose;
}

}  // namespace

Pose blend(const std::vector<std::pair<Pose, double>>& motions) {
  const Pose& first = motions.front().first;
  const bool are_alike = std::all_of(motions.begin(), motions.end(), [&](const auto& motion) {
    return isSame(motion.first, first);
  });
  if (are_alike) return first;
  const Eigen::Vector4d pivot = Eigen::Quaterniond(first.linear()).coeffs();
  Eigen::Vector4d turn = Eigen::Vector4d::Zero();
  Eigen::Vector4d shift = Eigen::Vector4d::Zero();  // of the dual part
  for (const auto& [motion, share] : motions) {
    const DualQuaternion q = toDualQuaternion(motion, pivot);
    turn += share * q.turn;
    shift += share * q.shift;
  }
  const double norm = turn.norm();
  const Eigen::Quaterniond real(Eigen::Vector4d(turn / norm));
  const Eigen::Quaterniond dual(Eigen::Vector4d(shift / norm));
  Pose blended = Pose::Identity();
  blended.linear() = real.toRotationMatrix();
  blended.translation() = 2.0 * (dual * real.conjugate()).vec();
  return blended;
}

Correction::Correction(std::vector<KeyframeMotion> motions) : motions_(std::move(motions)) {
  KeyframeId last;
  for (const KeyframeMotion& motion : motions_) {
    requireRigid(motion.id, motion.T_new_old);
    if (!(last < motion.id)) {
      throw std::invalid_argument("a correction names " + nameOf(motion.id) + " after " +
                                  nameOf(last) + ", expected ascending ids from 1 on");
    }
    last = motion.id;
  }
}

bool Correction::isIdentity() const {
  return isRigid() && (motions_.empty() || isSame(motions_[0].T_new_old, Pose::Identity()));
}

bool Correction::isRigid() const {
  return std::all_of(motions_.begin(), motions_.end(), [&](const KeyframeMotion& motion) {
    return isSame(motion.T_new_old, motions_[0].T_new_old);
  });
}

Pose Correction::at(const Anchors& anchors) const {
  std::vector<std::pair<Pose, double>> found;
  for (const auto& [id, share] : anchors) {
    const auto motion =
        findById(motions_, id, [](const KeyframeMotion& candidate) { return candidate.id; });
    if (motion == motions_.end()) {
      throw std::invalid_argument("the correction does not name " + nameOf(id));
    }
    found.emplace_back(motion->T_new_old, share);
  }
  return blend(found);
}

Correction computeCorrection(const Keyframes& before, const Keyframes& after) {
  requireSame("the frame", before.frame(), after.frame());
  requireSame("a number of keyframes of", before.list().size(), after.list().size());
  std::vector<KeyframeMotion> motions;
  for (std::size_t i = 0; i < before.list().size(); ++i) {
    const Keyframe& from = before.list()[i];
    const Keyframe& to = after.list()[i];
    requireSame("keyframe", from.id.value, to.id.value);
    requireSame(nameOf(from.id) + " at [ns]", from.stamp.ns, to.stamp.ns);
    motions.push_back({from.id, computeMotion(from.T_world_camera, to.T_world_camera)});
  }
  return Correction(std::move(motions));
}

Correction computeCorrection(const PoseGraph& before, const PoseGraph& after) {
  requireSame("a number of keyframes of", before.keyframes().size(), after.keyframes().size());
  std::vector<KeyframeMotion> motions;
  for (std::size_t i = 0; i < before.keyframes().size(); ++i) {
    const GraphKeyframe& from = before.keyframes()[i];
    const GraphKeyframe& to = after.keyframes()[i];
    requireSame("keyframe", from.id.value, to.id.value);
    motions.push_back({from.id, computeMotion(from.T_world_keyframe, to.T_world_keyframe)});
  }
  return Correction(std::move(motions));
}

Correction computeCorrection(const Keyframes& before, const Trajectory& corrected,
                             const std::string& corrected_frame, double max_gap_s) {
  requireSame("the frame", before.frame(), corrected_frame);
  std::vector<KeyframeMotion> motions;
  std::size_t num_before = 0;
  for (const Keyframe& keyframe : before.list()) {
    const auto pose = findPose(corrected, keyframe, max_gap_s);
    if (!pose && motions.empty()) {
      ++num_before;
      continue;
    }
    motions.push_back({keyframe.id, pose ? computeMotion(keyframe.T_world_camera, *pose)
                                         : motions.back().T_new_old});
  }
  if (motions.empty() && !before.isEmpty()) {
    throw std::invalid_argument("the corrected trajectory has no pose at the time of any keyframe");
  }
  std::vector<KeyframeMotion> all;
  for (std::size_t i = 0; i < num_before; ++i) {
    all.push_back({before.list()[i].id, motions.front().T_new_old});
  }
  all.insert(all.end(), motions.begin(), motions.end());
  return Correction(std::move(all));
}

Correction makeRigidCorrection(const Keyframes& keyframes, const Pose& T_new_old) {
  std::vector<KeyframeMotion> motions;
  for (const Keyframe& keyframe : keyframes.list()) motions.push_back({keyframe.id, T_new_old});
  return Correction(std::move(motions));
}

Keyframes applyCorrection(const Correction& correction, const Keyframes& keyframes) {
  std::vector<Pose> poses;
  for (const Keyframe& keyframe : keyframes.list()) {
    const Pose motion = correction.at({{keyframe.id, 1.0}});
    poses.push_back(move(keyframe.T_world_camera, motion));
  }
  return keyframes.withPoses(poses);
}

Trajectory applyCorrection(const Correction& correction, const Keyframes& keyframes,
                           const Trajectory& trajectory) {
  if (keyframes.isEmpty() && !trajectory.isEmpty()) {
    throw std::invalid_argument("a trajectory cannot follow: it has no keyframe");
  }
  Trajectory corrected;
  for (const auto& [ns, pose] : trajectory.poses()) {
    const Pose motion = correction.at(keyframes.anchorsAt({ns}));
    corrected.add({ns}, move(pose, motion));
  }
  return corrected;
}

}  // namespace tsg::trajectory
