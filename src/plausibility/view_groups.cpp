// SPDX-License-Identifier: BSD-3-Clause
#include "view_groups.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace tsg::plausibility {
namespace {

constexpr std::size_t kSourcePoints = 400;
constexpr std::size_t kMaxTargets = 3;
constexpr std::size_t kMaxPoses = 256;
constexpr double kMaxGroup_s = 20.0;  // what changes slowly in the scene must not matter
constexpr int kTopLevel = 4;
constexpr std::array<double, kTopLevel + 1> kTranslations_m{0.02, 0.04, 0.08, 0.16, 0.32};
constexpr std::array<double, kTopLevel + 1> kRotations_deg{1.0, 2.0, 4.0, 8.0, 16.0};
constexpr double kDegree = 3.14159265358979323846 / 180.0;

/// How far apart two poses are: an index into the tables above, -1 if less.
int computeLevel(const Pose& a, const Pose& b) {
  const double translation_m = (a.translation() - b.translation()).norm();
  const double cosine = 0.5 * ((a.linear().transpose() * b.linear()).trace() - 1.0);
  const double rotation_deg = std::acos(std::clamp(cosine, -1.0, 1.0)) / kDegree;
  int level = -1;
  for (std::size_t i = 0; i < kTranslations_m.size(); ++i) {
    if (translation_m >= kTranslations_m[i] || rotation_deg >= kRotations_deg[i]) {
      level = static_cast<int>(i);
    }
  }
  return level;
}

double distance_s(Stamp a, Stamp b) { return std::abs(secondsBetween(a, b)); }

bool isNearView(const ViewGroup& group, Stamp stamp) {
  const double reach_s = ViewGroups::kMaxDelay_s + 0.1;
  if (distance_s(group.source_pose.stamp, stamp) <= reach_s) return true;
  return std::any_of(group.targets.begin(), group.targets.end(), [&](const SampledView& view) {
    return distance_s(view.pose.stamp, stamp) <= reach_s;
  });
}

void prunePoses(ViewGroup& group) {
  const Stamp now = group.poses.back().stamp;
  const auto is_idle = [&](const StampedPose& pose) {
    return !isNearView(group, pose.stamp) &&
           distance_s(pose.stamp, now) > ViewGroups::kMaxDelay_s + 0.1;
  };
  group.poses.erase(std::remove_if(group.poses.begin(), group.poses.end(), is_idle),
                    group.poses.end());
  if (group.poses.size() > 4 * kMaxPoses) group.poses.clear();  // a very fast camera: no delays
}

Pose interpolate(const StampedPose& before, const StampedPose& after, Stamp stamp) {
  const double share =
      secondsBetween(before.stamp, stamp) / secondsBetween(before.stamp, after.stamp);
  const Eigen::Quaterniond from(before.T_world_camera.linear());
  const Eigen::Quaterniond to(after.T_world_camera.linear());
  Pose T = Pose::Identity();
  T.linear() = from.slerp(share, to).toRotationMatrix();
  T.translation() = (1.0 - share) * before.T_world_camera.translation() +
                    share * after.T_world_camera.translation();
  return T;
}

}  // namespace

std::optional<Pose> ViewGroup::findPose(Stamp stamp) const {
  const auto after =
      std::lower_bound(poses.begin(), poses.end(), stamp,
                       [](const StampedPose& pose, Stamp t) { return pose.stamp < t; });
  if (after == poses.end()) return std::nullopt;
  if (after->stamp == stamp) return after->T_world_camera;
  if (after == poses.begin()) return std::nullopt;
  return interpolate(*std::prev(after), *after, stamp);
}

bool ViewGroups::add(const RgbdFrame& frame) {
  if (!recent_.empty() && frame.stamp <= recent_.back().stamp) {
    closeGroup();
    recent_.clear();
  }
  recordPose({frame.stamp, frame.T_world_camera});
  if (is_open_ && isOutgrown(frame)) closeGroup();
  if (is_open_) {
    extendGroup(frame);
    return false;
  }
  const bool is_due =
      groups_.empty() || distance_s(groups_.back().source_pose.stamp, frame.stamp) >= min_gap_s_;
  if (is_due) startGroup(frame);
  return is_due;
}

bool ViewGroups::isOutgrown(const RgbdFrame& frame) const {
  const ViewGroup& group = groups_.back();
  return group.camera != frame.camera ||
         secondsBetween(group.source_pose.stamp, frame.stamp) > kMaxGroup_s;
}

void ViewGroups::closeGroup() {
  if (is_open_ && groups_.back().targets.empty()) groups_.pop_back();
  is_open_ = false;
}

void ViewGroups::startGroup(const RgbdFrame& frame) {
  if (groups_.size() >= kMaxGroups) thinOut();
  ViewGroup group;
  group.id = next_id_++;
  group.source_pose = {frame.stamp, frame.T_world_camera};
  group.camera = frame.camera;
  group.source = pickPixels(sampleDepth(frame, kGridWidth_px), kSourcePoints);
  group.poses.assign(recent_.begin(), recent_.end());
  groups_.push_back(std::move(group));
  is_open_ = true;
}

void ViewGroups::extendGroup(const RgbdFrame& frame) {
  ViewGroup& group = groups_.back();
  const int level = computeLevel(group.source_pose.T_world_camera, frame.T_world_camera);
  if (level <= group.level) return;
  group.level = level;
  if (group.targets.size() == kMaxTargets) group.targets.erase(group.targets.begin());
  group.targets.push_back({{frame.stamp, frame.T_world_camera}, sampleDepth(frame, kGridWidth_px)});
  if (level == kTopLevel) closeGroup();
}

void ViewGroups::recordPose(const StampedPose& pose) {
  recent_.push_back(pose);
  const auto is_old = [&] {
    return recent_.size() > kMaxPoses ||
           secondsBetween(recent_.front().stamp, pose.stamp) > kMaxDelay_s + 0.1;
  };
  while (is_old()) recent_.pop_front();
  for (ViewGroup& group : groups_) {
    const bool is_open = is_open_ && &group == &groups_.back();
    if (!is_open && !isNearView(group, pose.stamp)) continue;
    group.poses.push_back(pose);
    if (group.poses.size() > kMaxPoses) prunePoses(group);
  }
}

void ViewGroups::thinOut() {
  std::vector<ViewGroup> kept;
  for (std::size_t i = 0; i < groups_.size(); i += 2) kept.push_back(std::move(groups_[i]));
  const double span_s = distance_s(kept.front().source_pose.stamp, kept.back().source_pose.stamp);
  min_gap_s_ = span_s / static_cast<double>(kept.size());
  groups_ = std::move(kept);
}

}  // namespace tsg::plausibility
