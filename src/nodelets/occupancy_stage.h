// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

#include "map_correction.h"
#include "task_scene_graph/core/files.h"
#include "task_scene_graph/mapping/occupancy_map.h"
#include "task_scene_graph/ros/byte_budget.h"
#include "task_scene_graph/ros/late_subscribers.h"
#include "task_scene_graph/ros/occupancy_publisher.h"
#include "task_scene_graph/ros/stage_report.h"
#include "task_scene_graph/ros/worker.h"

namespace tsg::nodelets {

/// Frames -> the occupancy map, in a thread of its own: it may cost more than the rest of depth
/// integration together, which does not wait for it. Thread-safe.
class OccupancyStage {
 public:
  struct Options {
    mapping::OccupancyConfig occupancy;
    std::string world_frame;
    double period_s = 1.0;                  ///< between two messages
    std::size_t max_frames = 100;           ///< that wait; beyond it the oldest is dropped
    std::size_t max_frame_bytes = 1 << 28;  ///< of their images; beyond it a new one is dropped
  };

  /// Advertises `octomap`, `octomap_changes`, `octomap_markers`.
  /// @param late, report  must outlive this object
  OccupancyStage(ros::NodeHandle& handle, ros_interface::LateSubscribers& late,
                 const Options& options, ros_interface::StageReport& report);
  ~OccupancyStage() { stop(); }

  /// A frame whose depth is filtered. Never blocks for long.
  void add(const RgbdFramePtr& frame);
  /// Moves the voxels of all frames given before, and tells subscribers. Never blocks for long.
  void correct(const MapCorrectionPtr& correction);
  /// Waits until all is integrated, and publishes what is. False if the deadline passes first.
  bool flush(std::chrono::steady_clock::time_point deadline);
  /// Forgets the map and what waits, and tells subscribers.
  void clear(Stamp stamp);
  /// A copy of the map of now. O(nodes).
  std::shared_ptr<const mapping::OccupancyMap> snapshot() const;
  /// Goes on from this map instead, and tells subscribers. What waits is dropped.
  void restore(const mapping::OccupancyMap& map, Stamp stamp);
  /// Drops what waits and joins the thread.
  void stop() { worker_.stop(); }

 private:
  struct Job {
    RgbdFramePtr frame;
    ros_interface::ByteBudget::Share share;
    std::uint64_t num_clears = 0;
    MapCorrectionPtr correction;  ///< instead of a frame
  };

  void process(const Job& job);
  void follow(const Job& job);
  void reportCounters();

  const Options options_;
  ros_interface::StageReport& report_;
  ros_interface::ByteBudget budget_;
  std::atomic<std::uint64_t> num_clears_{0};  ///< frames of before a clear are not integrated
  mutable std::mutex mutex_;                  ///< guards all below but the worker
  mapping::OccupancyMap map_;
  Stamp newest_;
  ros_interface::OccupancyPublisher publisher_;
  ros_interface::Worker<Job> worker_;
};

}  // namespace tsg::nodelets
