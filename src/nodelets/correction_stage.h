// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nav_msgs/Path.h>
#include <ros/node_handle.h>
#include <tf2/buffer_core.h>
#include <visualization_msgs/MarkerArray.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "correction_config.h"
#include "loop_stage.h"
#include "map_correction.h"
#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/core/trajectory.h"
#include "task_scene_graph/ros/stage_report.h"
#include "task_scene_graph/ros/state_publisher.h"
#include "task_scene_graph/ros/transform_feed.h"
#include "task_scene_graph/ros/transform_history.h"
#include "task_scene_graph/ros/worker.h"

namespace tsg::nodelets {

/// Gives frames, whose poses come in the odometry frame, their place in the map, and moves the map
/// when a correction of its trajectory comes: a path of a SLAM system, a jump of the map's frame in
/// tf, or loop closures of our own; with these it tells tf where the odometry's frame lies. One
/// correction is under way at a time; while it is, of several paths the newest waits.
///
/// A fault of a correction changes nothing, is a warning, and is counted. Thread-safe.
class CorrectionStage {
 public:
  struct Options {
    CorrectionConfig config;
    std::string world_frame;
  };
  struct Callbacks {
    /// Queues a correction for all parts of the map; under the lock of place().
    std::function<void(const MapCorrectionPtr&)> apply;
    /// The frame of the images; "" before the first one.
    std::function<std::string()> camera_frame;
  };

  /// Advertises `trajectory` and `trajectory_before` where it is on, with loop closures
  /// `loop_closures`.
  /// @param options  as checkCorrections() wants them
  /// @param report  must outlive this object
  CorrectionStage(ros::NodeHandle& handle, const Options& options,
                  ros_interface::StageReport& report, Callbacks callbacks);
  ~CorrectionStage() { stop(); }

  bool isOn() const { return !options_.config.odometry_frame.empty(); }

  /// Hands on a new frame at its place in the map, before or after any correction as a whole; the
  /// frame itself where this is off. Nothing, and it is counted, while tf does not know where the
  /// odometry is.
  void placeNew(const RgbdFramePtr& frame, const std::function<void(const RgbdFramePtr&)>& hand_on);
  /// ... one that placeNew() has had before, where it lies now.
  void placeAgain(const RgbdFramePtr& frame,
                  const std::function<void(const RgbdFramePtr&)>& hand_on);

  /// Moves the map as loop closures say. Blocks while another correction is under way, a minute at
  /// most.
  void follow(const LoopResult& loops);

  /// Begins no correction for some seconds, so that what is written of the map fits together; until
  /// release(). One that is under way goes on: flush the stages after this.
  void hold();
  void release();
  /// Stamps have jumped back: paths are refused from now on, they cannot say which pass they are
  /// of.
  void startEpoch();
  /// The map is another one, with this trajectory.
  void restart(const Trajectory& trajectory);
  /// About once a second: lines of the diagnostics, `trajectory`.
  void check();
  /// Begins no correction any more.
  void stop();

 private:
  bool followsTf() const {
    return isOn() && options_.config.path_topic.empty() && !options_.config.close_loops;
  }
  bool isBusy() const;
  void waitWhileBusy() const;
  Pose toWorld(const RgbdFrame& frame) const;
  std::optional<Pose> lookUpOdometry() const;
  void followTf(const RgbdFrame& frame);
  void startAtOdometry();
  void sendOdometry(Stamp stamp) const;
  void process(const nav_msgs::PathConstPtr& path);
  Trajectory readPath(const nav_msgs::Path& path) const;
  Trajectory computeReported() const;
  void correctTo(const Trajectory& reported, const Trajectory& corrected);
  void correct(trajectory::OutsideCorrection correction);
  void refuse(const std::string& source, const std::string& reason);
  bool isWorthIt(double motion_m, double turn_rad) const;
  void publish(const ros_interface::StatePublisher<nav_msgs::Path>& publisher,
               const Trajectory& trajectory) const;

  const Options options_;
  ros_interface::StageReport& report_;
  const Callbacks callbacks_;
  tf2::BufferCore tf_;
  ros_interface::TransformHistory tf_history_;
  std::unique_ptr<ros_interface::TransformFeed> tf_feed_;  ///< null while off
  std::atomic<bool> is_stopped_{false};
  mutable std::mutex mutex_;              ///< guards all below
  std::optional<Pose> T_world_odometry_;  ///< that frames are placed with; none: not known yet
  Trajectory own_;                        ///< of the camera, world frame, where the map has it
  bool has_jumped_back_ = false;
  std::chrono::steady_clock::time_point held_until_;
  std::weak_ptr<const MapCorrection> under_way_;
  std::uint64_t num_applied_ = 0;
  std::uint64_t num_refused_ = 0;
  std::uint64_t num_small_ = 0;
  std::string last_refusal_;
  ros_interface::StatePublisher<nav_msgs::Path> trajectory_publisher_;
  ros_interface::StatePublisher<nav_msgs::Path> before_publisher_;
  ros_interface::StatePublisher<visualization_msgs::MarkerArray> loop_publisher_;
  ros::Publisher tf_publisher_;  ///< none unless loop closures say where the odometry is
  ros::Subscriber path_subscriber_;
  ros_interface::Worker<nav_msgs::PathConstPtr> worker_;
};

}  // namespace tsg::nodelets
