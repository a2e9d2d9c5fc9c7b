// SPDX-License-Identifier: BSD-3-Clause
#include "pose_smoothness.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tsg::plausibility {
namespace {

constexpr double kDegrees = 180.0 / 3.14159265358979323846;
constexpr double kMaxGap_s = 0.25;
constexpr std::size_t kMinSamples = 15;
constexpr double kTrimmedShare = 0.1;
constexpr double kMinJolt_m = 0.012;
constexpr double kMinTwist_rad = 0.012;
constexpr double kMinRatio = 0.8;  // hand-held recordings: up to 0.7
constexpr double kMinHeldShare = 0.3;

double computeTrimmedRms(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto kept = static_cast<std::size_t>(
      std::ceil((1.0 - kTrimmedShare) * static_cast<double>(values.size())));
  double squares = 0.0;
  for (std::size_t i = 0; i < kept; ++i) squares += values[i] * values[i];
  return kept == 0 ? 0.0 : std::sqrt(squares / static_cast<double>(kept));
}

}  // namespace

void PoseSmoothness::add(Stamp stamp, const Pose& T_world_camera) {
  const std::optional<Stamp> before = last_stamp_;
  const Pose T_before_now = last_pose_.inverse(Eigen::Isometry) * T_world_camera;
  last_stamp_ = stamp;
  last_pose_ = T_world_camera;
  const double dt_s = before ? secondsBetween(*before, stamp) : 0.0;
  if (!(dt_s > 0.0 && dt_s <= kMaxGap_s)) {
    last_motion_.reset();
    return;
  }
  const Eigen::AngleAxisd turn(T_before_now.linear());
  const Motion motion{dt_s, T_before_now.translation(), turn.angle() * turn.axis()};
  if (last_motion_) {
    const double scale = dt_s / last_motion_->dt_s;
    samples_.push_back({motion.step_m.norm(), (motion.step_m - scale * last_motion_->step_m).norm(),
                        motion.turn_rad.norm(),
                        (motion.turn_rad - scale * last_motion_->turn_rad).norm(),
                        motion.step_m.isZero(0.0) && motion.turn_rad.isZero(1e-9)});
    if (samples_.size() > kMemory) samples_.pop_front();
  }
  last_motion_ = motion;
}

PoseSmoothness::Roughness PoseSmoothness::computeRoughness() const {
  const auto rms = [&](double Sample::*value) {
    std::vector<double> values;
    for (const Sample& sample : samples_) values.push_back(sample.*value);
    return computeTrimmedRms(std::move(values));
  };
  Roughness roughness{rms(&Sample::step_m), rms(&Sample::jolt_m), rms(&Sample::turn_rad),
                      rms(&Sample::twist_rad), 0.0};
  const auto held =
      std::count_if(samples_.begin(), samples_.end(), [](const Sample& s) { return s.is_held; });
  if (!samples_.empty()) {
    roughness.held_share = static_cast<double>(held) / static_cast<double>(samples_.size());
  }
  return roughness;
}

bool PoseSmoothness::isRough() const {
  if (samples_.size() < kMinSamples) return false;
  const Roughness r = computeRoughness();
  return (r.jolt_m > kMinRatio * r.step_m && r.jolt_m > kMinJolt_m) ||
         (r.twist_rad > kMinRatio * r.turn_rad && r.twist_rad > kMinTwist_rad);
}

Finding describeRoughness(const PoseSmoothness::Roughness& roughness) {
  Finding finding;
  finding.check = "pose jitter";
  finding.seen = "from image to image the pose moves by " + formatNumber(100.0 * roughness.step_m) +
                 " cm and " + formatNumber(roughness.turn_rad * kDegrees) +
                 " degrees, and that motion changes by " + formatNumber(100.0 * roughness.jolt_m) +
                 " cm and " + formatNumber(roughness.twist_rad * kDegrees) +
                 " degrees; depth reprojected between neighbouring frames does not agree";
  if (roughness.held_share > kMinHeldShare) {
    finding.seen += "; " + formatShare(roughness.held_share) +
                    " of the images have exactly the pose of the image before";
    finding.meaning = "usually poses come less often than images and nobody interpolates them";
    finding.remedy =
        "publish tf (pose_topic, trajectory) at the images' rate or with stamps that"
        " can be interpolated";
  } else {
    finding.meaning = "usually the poses are noisy, or two sources publish the same transform";
    finding.remedy =
        "smooth the poses, and look for a second publisher (rosrun tf view_frames,"
        " rostopic info /tf)";
  }
  return finding;
}

}  // namespace tsg::plausibility
