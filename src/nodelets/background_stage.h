// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "task_scene_graph/core/files.h"
#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/pipeline/background_fusion.h"
#include "task_scene_graph/ros/mesh_publisher.h"
#include "task_scene_graph/ros/occupancy_publisher.h"
#include "task_scene_graph/ros/stage_report.h"
#include "task_scene_graph/ros/worker.h"

namespace tsg::nodelets {

struct BackgroundStageOptions {
  pipeline::BackgroundFusionConfig fusion;
  std::string world_frame;
  double mesh_period_s = 1.0;
  double octomap_period_s = 1.0;
  std::size_t queue_size = 100;  ///< frames and views that wait
};

/// Every frame -> background mesh, places, occupancy map: their thread, their topics, their files.
/// Thread-safe.
class BackgroundStage {
 public:
  /// Advertises `mesh`, `mesh_blocks`, `place_graph` and, where enabled, `octomap...`.
  /// @param report  must outlive this object
  BackgroundStage(ros::NodeHandle& handle, const BackgroundStageOptions& options,
                  ros_interface::StageReport& report);

  /// A frame to integrate. Never blocks for long.
  void addFrame(const RgbdFramePtr& frame);
  /// The image embedding of a frame, for the places that it sees. Never blocks for long.
  void addView(const RgbdFramePtr& frame, const SegmentationPtr& segmentation);

  /// About once a second: lines of the diagnostics.
  void check();
  /// Waits until all is integrated, and publishes what is, due or not. False if the deadline passes
  /// first.
  bool flush(std::chrono::steady_clock::time_point deadline);
  /// Drops what waits and joins the thread. Nothing may be added from now on.
  void stop() { worker_.stop(); }

  /// Stamp of the newest integrated frame; 0 if there is none.
  Stamp newestFrame() const;
  /// Stamp of the newest place graph that was published; 0 if there is none.
  Stamp newestPlaces() const;

  /// Writes `mesh.ply` with the given objects, and the occupancy map's files.
  /// @throws as pipeline::writeMeshFile() and pipeline::writeOccupancyFiles().
  std::vector<WrittenFile> writeFiles(
      const std::filesystem::path& folder, const std::vector<ObjectPrimitivePtr>& primitives,
      const std::map<PrimitiveId, std::int32_t>& object_of_primitive);

 private:
  /// A frame to integrate, or, with a segmentation, a view for the places.
  struct Job {
    RgbdFramePtr frame;
    SegmentationPtr segmentation;
  };

  void process(const Job& job);
  void publish(bool force);
  void publishPlaces(bool force);

  const BackgroundStageOptions options_;
  ros_interface::StageReport& report_;
  mutable std::mutex mutex_;  ///< guards the three below, and what the publishers read of the first
  pipeline::BackgroundFusion fusion_;
  Stamp newest_frame_;
  Stamp newest_places_;
  ros_interface::MeshPublisher mesh_publisher_;
  std::unique_ptr<ros_interface::OccupancyPublisher> occupancy_publisher_;  ///< null if off
  ros::Publisher places_publisher_;
  ros_interface::Worker<Job> worker_;
};

}  // namespace tsg::nodelets
