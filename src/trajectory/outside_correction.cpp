// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/trajectory/outside_correction.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/trajectory/se3.h"

namespace tsg::trajectory {
namespace {

constexpr double kRounding = 1e-9;  ///< metres and radians, of poses that were written and read
constexpr std::size_t kLeastPoses = 2;
constexpr double kSameMotion_m = 0.02;  ///< of one keyframe and of what is seen before the next
constexpr double kSameTurn_rad = 0.005;

std::string describeSpan(const Trajectory& trajectory) {
  std::ostringstream text;
  text.precision(14);
  text << trajectory.first().seconds() << " to " << trajectory.last().seconds() << " s";
  return text.str();
}

/// How what was seen from a pose moves; the identity where that is rounding.
Pose computeMotion(const Pose& before, const Pose& after) {
  const Pose shift = before.inverse() * after;
  const bool is_still = shift.translation().norm() < kRounding && computeAngle(shift) < kRounding;
  return is_still ? Pose::Identity() : after * before.inverse();
}

void requireRigid(std::int64_t stamp_ns, const Pose& pose) {
  if (isRigid(pose)) return;
  throw std::invalid_argument("the corrected pose at stamp " + std::to_string(stamp_ns) +
                              " ns is not finite or no rotation");
}

void requirePoses(const Trajectory& own, const Trajectory& corrected) {
  if (corrected.isEmpty()) {
    throw std::invalid_argument("the corrected trajectory has no pose, expected 2 at least");
  }
  if (own.isEmpty()) {
    throw std::invalid_argument("the map has no trajectory that a corrected one could be of");
  }
}

void requireCommon(std::size_t num_common, const Trajectory& own, const Trajectory& corrected) {
  if (num_common >= kLeastPoses) return;
  std::ostringstream text;
  text << num_common << " of " << corrected.size() << " poses of the corrected trajectory ("
       << describeSpan(corrected) << ") lie within the map's (" << describeSpan(own)
       << "), expected " << kLeastPoses << " at least";
  throw std::invalid_argument(text.str());
}

/// Gathers keyframes and their motions.
class Gatherer {
 public:
  Gatherer(const std::string& frame, const OutsideCorrectionConfig& config)
      : config_(config), before_(frame, config.keyframes) {}

  void add(Stamp stamp, const Pose& T_world_camera, const Pose& motion) {
    if (!motions_.empty() && differs(motions_.back().T_new_old, motion, T_world_camera)) {
      appendLast();  // so far all moved alike
      append(stamp, T_world_camera, motion);
    } else if (const auto id = before_.add(stamp, T_world_camera)) {
      motions_.push_back({*id, motion});
    }
    last_ = Keyframe{{}, stamp, T_world_camera};
    last_motion_ = motion;
    ++num_poses_;
  }

  std::size_t numPoses() const { return num_poses_; }

  /// The last pose is a keyframe, too: what comes after moves with it.
  OutsideCorrection finish() {
    appendLast();
    OutsideCorrection result{before_, Correction(motions_)};
    for (std::size_t i = 0; i < motions_.size(); ++i) {
      const Eigen::Vector3d at_m = before_.list()[i].T_world_camera.translation();
      const Pose& motion = motions_[i].T_new_old;
      result.max_motion_m = std::max(result.max_motion_m, (motion * at_m - at_m).norm());
      result.max_turn_rad = std::max(result.max_turn_rad, computeAngle(motion));
    }
    requireNear(result.max_motion_m);
    return result;
  }

 private:
  /// Whether two motions bring a pose to places that are apart.
  static bool differs(const Pose& a, const Pose& b, const Pose& T_world_camera) {
    const Pose between = (a * T_world_camera).inverse() * (b * T_world_camera);
    return between.translation().norm() > kSameMotion_m || computeAngle(between) > kSameTurn_rad;
  }

  void append(Stamp stamp, const Pose& T_world_camera, const Pose& motion) {
    motions_.push_back({before_.append(stamp, T_world_camera), motion});
  }

  /// The last pose, if it is no keyframe.
  void appendLast() {
    if (num_poses_ == 0 || !(before_.list().back().stamp < last_.stamp)) return;
    append(last_.stamp, last_.T_world_camera, last_motion_);
  }

  void requireNear(double motion_m) const {
    if (motion_m <= config_.max_motion_m) return;
    std::ostringstream text;
    text << "the correction moves the camera by " << motion_m << " m, expected at most "
         << config_.max_motion_m << " m (max_motion_m)";
    throw std::invalid_argument(text.str());
  }

  const OutsideCorrectionConfig& config_;
  Keyframes before_;
  std::vector<KeyframeMotion> motions_;
  Keyframe last_;
  Pose last_motion_ = Pose::Identity();
  std::size_t num_poses_ = 0;
};

}  // namespace

OutsideCorrection computeOutsideCorrection(const Trajectory& own, const Trajectory& reported,
                                           const Trajectory& corrected, const std::string& frame,
                                           const OutsideCorrectionConfig& config) {
  config::validate(config, "correction");
  requirePoses(own, corrected);
  Gatherer gatherer(frame, config);
  for (const auto& [ns, pose] : corrected.poses()) {
    requireRigid(ns, pose);
    const auto T_world_camera = own.interpolate({ns}, config.max_gap_s);
    const auto before = reported.interpolate({ns}, config.max_gap_s);
    if (T_world_camera && before) {
      gatherer.add({ns}, *T_world_camera, computeMotion(*before, pose));
    }
  }
  requireCommon(gatherer.numPoses(), own, corrected);
  return gatherer.finish();
}

OutsideCorrection makeOutsideCorrection(const Trajectory& own, const Pose& T_new_old,
                                        const std::string& frame,
                                        const OutsideCorrectionConfig& config) {
  config::validate(config, "correction");
  if (own.isEmpty()) throw std::invalid_argument("the map has no trajectory that could move");
  if (!isRigid(T_new_old)) {
    throw std::invalid_argument("the correction is not finite or no rotation");
  }
  Gatherer gatherer(frame, config);
  for (const auto& [ns, pose] : own.poses()) gatherer.add({ns}, pose, T_new_old);
  return gatherer.finish();
}

}  // namespace tsg::trajectory
