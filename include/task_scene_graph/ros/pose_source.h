// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <tf2/buffer_core.h>

#include <boost/shared_ptr.hpp>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "task_scene_graph/core/trajectory.h"
#include "task_scene_graph/ros/input_config.h"
#include "task_scene_graph/ros/transform_history.h"

namespace tsg::ros_interface {

/// Where the camera was at a stamp: from tf, or from a trajectory (a file, or a topic's messages as
/// they come) with tf for the fixed links around it. Thread-safe.
///
/// With a trajectory: T_world_camera = T_world_parent * T_parent_pose_frame * T_pose_frame_camera.
/// The links to the world and to the camera come from tf; where tf does not know the parent frame,
/// its poses are taken as poses in the world, and `note()` says so.
class PoseSource {
 public:
  /// Reads the trajectory, if one is given. `tf` must live longer.
  /// @param history  of the moving links in `tf`, noted before `tf` has them; null: holes in tf are
  /// interpolated over unseen
  /// @throws std::runtime_error naming the file, config::ConfigError as checkInput().
  PoseSource(const InputConfig& config, const tf2::BufferCore& tf,
             const TransformHistory* history = nullptr);

  bool usesTopic() const { return !config_.pose_topic.empty(); }
  bool usesTf() const { return config_.pose_topic.empty() && config_.trajectory.empty(); }

  /// Takes one message of the pose topic. `Message` has `getDataType()` and `instantiate<T>()`:
  /// topic_tools::ShapeShifter, BagMessage. @throws InputError for other types and for
  /// values that are no pose.
  template <typename Message>
  void add(const Message& message) {
    if (const auto odometry = message.template instantiate<nav_msgs::Odometry>()) {
      addPose(odometry->header, odometry->child_frame_id, odometry->pose.pose);
    } else if (const auto pose = message.template instantiate<geometry_msgs::PoseStamped>()) {
      addPose(pose->header, "", pose->pose);
    } else if (const auto with_covariance =
                   message.template instantiate<geometry_msgs::PoseWithCovarianceStamped>()) {
      addPose(with_covariance->header, "", with_covariance->pose.pose);
    } else if (const auto transform =
                   message.template instantiate<geometry_msgs::TransformStamped>()) {
      addTransform(*transform);
    } else {
      failType(message.getDataType());
    }
  }

  struct Answer {
    std::optional<Pose> T_world_camera;
    std::string reason;     ///< for a counter: "no transform", "hole in tf", "no pose"
    std::string why_not;    ///< what is missing, at which stamp, and what to do
    bool is_final = false;  ///< waiting longer is of no use
  };
  /// Pose of the camera's optical frame. Cheap; never waits.
  Answer lookUp(const std::string& camera_frame, Stamp stamp) const;
  /// Something the user should know of the poses so far; empty if there is nothing.
  std::string note() const;
  /// Forgets poses of a topic that are older than its newest by more than a minute.
  void forgetOld();
  /// Stamps have jumped back: forgets what a topic has brought.
  void clear();

 private:
  void addPose(const std_msgs::Header& header, const std::string& child_frame,
               const geometry_msgs::Pose& pose);
  void addTransform(const geometry_msgs::TransformStamped& transform);
  [[noreturn]] void failType(const std::string& type) const;
  Answer lookUpTf(const std::string& target, const std::string& source, Stamp stamp) const;
  /// The hole in tf that a pose at the stamp would be interpolated over; nothing where that does no
  /// harm.
  std::optional<TransformHistory::Gap> findHole(const std::string& target,
                                                const std::string& source, Stamp stamp) const;
  bool hasMoved(const std::string& target, const std::string& source,
                const TransformHistory::Gap& gap) const;
  Answer lookUpTrajectory(const std::string& camera_frame, Stamp stamp) const;
  Answer explainMissingPose(Stamp stamp) const;
  std::string sourceName() const;

  const InputConfig config_;
  const tf2::BufferCore& tf_;
  const TransformHistory* const history_;  ///< may be null
  mutable std::mutex mutex_;               ///< guards all below
  mutable std::string slow_link_;          ///< what is to be said of a link of tf
  Trajectory trajectory_;
  std::string parent_frame_;
  std::string child_frame_;
};

}  // namespace tsg::ros_interface
