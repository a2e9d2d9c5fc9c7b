// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/trajectory/keyframes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/core/find_by_id.h"
#include "task_scene_graph/trajectory/se3.h"

namespace tsg::trajectory {
namespace {

constexpr double kLeastWay_m = 0.01;  ///< no edge is surer than after this

std::string describeStamp(Stamp stamp) { return "stamp " + std::to_string(stamp.ns) + " ns"; }

}  // namespace

Keyframes::Keyframes(std::string frame, const KeyframeConfig& config)
    : frame_(std::move(frame)), config_(config) {
  config::validate(config, "keyframes");
}

const Keyframe* Keyframes::find(KeyframeId id) const {
  const auto found = findById(list_, id, [](const Keyframe& keyframe) { return keyframe.id; });
  return found == list_.end() ? nullptr : &*found;
}

void Keyframes::requireNext(Stamp stamp, const Pose& T_world_camera) const {
  if (!isRigid(T_world_camera)) {
    throw std::invalid_argument("the pose at " + describeStamp(stamp) +
                                " is not finite or no rotation");
  }
  if (list_.empty() || list_.back().stamp < stamp) return;
  throw std::invalid_argument("a pose at " + describeStamp(stamp) +
                              ", expected one after the last keyframe's " +
                              describeStamp(list_.back().stamp));
}

std::optional<KeyframeId> Keyframes::add(Stamp stamp, const Pose& T_world_camera) {
  requireNext(stamp, T_world_camera);
  if (!list_.empty()) {
    const Pose motion = list_.back().T_world_camera.inverse() * T_world_camera;
    const bool is_near = motion.translation().norm() < config_.distance_m &&
                         computeAngle(motion) < config_.angle_rad;
    if (is_near) return std::nullopt;
  }
  return append(stamp, T_world_camera);
}

KeyframeId Keyframes::append(Stamp stamp, const Pose& T_world_camera) {
  requireNext(stamp, T_world_camera);
  const KeyframeId id{list_.size() + 1};
  list_.push_back({id, stamp, T_world_camera});
  return id;
}

Keyframes Keyframes::withPoses(const std::vector<Pose>& T_world_camera) const {
  if (T_world_camera.size() != list_.size()) {
    throw std::invalid_argument(std::to_string(T_world_camera.size()) + " poses for " +
                                std::to_string(list_.size()) + " keyframes");
  }
  Keyframes moved = *this;
  for (std::size_t i = 0; i < list_.size(); ++i) moved.list_[i].T_world_camera = T_world_camera[i];
  return moved;
}

Anchors Keyframes::anchorsAt(Stamp stamp) const {
  const auto after =
      std::lower_bound(list_.begin(), list_.end(), stamp,
                       [](const Keyframe& keyframe, Stamp s) { return keyframe.stamp < s; });
  if (after == list_.end()) return {{list_.back().id, 1.0}};
  if (after == list_.begin() || after->stamp == stamp) return {{after->id, 1.0}};
  const auto before = std::prev(after);
  const double share =
      secondsBetween(before->stamp, stamp) / secondsBetween(before->stamp, after->stamp);
  return {{before->id, 1.0 - share}, {after->id, share}};
}

Keyframes selectKeyframes(const Trajectory& trajectory, std::string frame,
                          const KeyframeConfig& config) {
  Keyframes keyframes(std::move(frame), config);
  for (const auto& [ns, pose] : trajectory.poses()) keyframes.add({ns}, pose);
  return keyframes;
}

PoseEdge makeOdometryEdge(const Keyframe& a, const Keyframe& b, const OdometryNoise& noise) {
  PoseEdge edge{a.id, b.id, a.T_world_camera.inverse() * b.T_world_camera};
  const double way =
      std::max(kLeastWay_m, edge.T_a_b.translation().norm() + computeAngle(edge.T_a_b));
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(way * noise.position_m * noise.position_m),
      Eigen::Vector3d::Constant(way * noise.angle_rad * noise.angle_rad);
  edge.information = variances.cwiseInverse().asDiagonal();
  return edge;
}

PoseGraph makePoseGraph(const Keyframes& keyframes, const OdometryNoise& noise,
                        const PoseGraphConfig& config) {
  config::validate(noise, "odometry");
  PoseGraph graph(config);
  const Keyframe* last = nullptr;
  for (const Keyframe& keyframe : keyframes.list()) {
    if (last == nullptr) {
      graph.addKeyframe(keyframe.id, keyframe.T_world_camera);
    } else {
      graph.extend(makeOdometryEdge(*last, keyframe, noise));
    }
    last = &keyframe;
  }
  return graph;
}

}  // namespace tsg::trajectory
