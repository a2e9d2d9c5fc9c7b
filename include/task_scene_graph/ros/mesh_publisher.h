// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <mutex>
#include <optional>
#include <string>

#include "task_scene_graph/pipeline/background_fusion.h"
#include "task_scene_graph/ros/mesh_markers.h"
#include "task_scene_graph/ros/mesh_update_conversions.h"

namespace tsg::ros_interface {

/// Publishes the background mesh: `mesh` (markers) and `mesh_blocks` (MeshUpdate). Nothing is made
/// that nobody listens to; a late subscriber is first sent all there is.
class MeshPublisher {
 public:
  struct Options {
    std::string world_frame;
    double period_s = 1.0;  ///< least time, of the frames' stamps, between two updates
  };

  /// @param fusion        must outlive this object.
  /// @param fusion_mutex  guards it; locked when a subscriber comes.
  MeshPublisher(ros::NodeHandle& handle, const Options& options, pipeline::BackgroundFusion& fusion,
                std::mutex& fusion_mutex);

  /// Meshes and publishes what is due at `stamp` (or `force`). Precondition: the caller holds
  /// fusion_mutex.
  void publish(Stamp stamp, bool force);

 private:
  void greetMarkers(const ros::SingleSubscriberPublisher& subscriber);
  void greetBlocks(const ros::SingleSubscriberPublisher& subscriber);
  FindMesh meshFinder() const;

  Options options_;
  pipeline::BackgroundFusion& fusion_;
  std::mutex& fusion_mutex_;
  std::optional<Stamp> last_;
  MeshMarkers markers_;
  MeshUpdateWriter blocks_;
  ros::Publisher markers_publisher_;
  ros::Publisher blocks_publisher_;
};

}  // namespace tsg::ros_interface
