// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <chrono>
#include <cstdint>
#include <mutex>
#include <set>
#include <string>

#include "task_scene_graph/mapping/background_map.h"
#include "task_scene_graph/ros/late_subscribers.h"
#include "task_scene_graph/ros/mesh_markers.h"
#include "task_scene_graph/ros/mesh_update_conversions.h"
#include "task_scene_graph/ros/worker.h"

namespace tsg::ros_interface {

/// Publishes the background mesh: `mesh` (markers) and `mesh_blocks` (MeshUpdate). Nothing is made
/// that nobody listens to. A thread of its own sends the changes, from a table of meshes that never
/// changes; a late subscriber is sent all there is by another, part by part. Whoever calls waits
/// for neither. Thread-safe.
class MeshPublisher {
 public:
  /// Messages that wait for one slow subscriber; each has about 1 MB at most.
  static constexpr std::uint32_t kQueueSize = 64;

  /// @param late    serves late subscribers; must outlive this object
  /// @param report  is told of errors; must outlive this object
  MeshPublisher(ros::NodeHandle& handle, LateSubscribers& late, StageReport& report,
                const std::string& world_frame, double block_size_m);
  ~MeshPublisher() { stop(); }

  /// Sends what an update changed. While the thread is busy, updates that wait become one.
  /// @param meshes  as of the update
  void add(const mapping::MeshUpdate& update, const mapping::MeshTable& meshes, Stamp stamp);
  /// Tells subscribers that there is no mesh any more; updates that wait are dropped.
  void clear(Stamp stamp);

  bool waitIdle(std::chrono::steady_clock::time_point deadline) {
    return worker_.waitIdle(deadline);
  }
  /// Drops what waits and joins the thread.
  void stop() { worker_.stop(); }

 private:
  using Blocks = std::set<mapping::GridIndex, BlockOrder>;
  /// What is still to be sent.
  struct Pending {
    bool is_cleared = false;  ///< before the rest
    Blocks touched;
    mapping::MeshTable meshes;
    Stamp stamp;
  };
  struct Wake {};

  void process();
  void sendClear();
  void sendMarkers(const Blocks& touched);
  void sendBlocks(const Blocks& touched);
  void serveMarkers(PartSender& sender);
  void serveBlocks(PartSender& sender);

  StageReport& report_;
  std::mutex pending_mutex_;  ///< guards the next
  Pending pending_;
  /// Held while a part or a change is made and queued, so that all subscribers get them in order;
  /// guards all below but the publishers. Nobody who integrates depth ever takes it.
  std::mutex send_mutex_;
  mapping::MeshTable meshes_;  ///< as sent last
  Stamp stamp_;
  std::uint64_t num_clears_ = 0;
  MeshMarkers markers_;
  MeshUpdateWriter blocks_;
  ros::Publisher markers_publisher_;
  ros::Publisher blocks_publisher_;
  Worker<Wake> worker_;
};

}  // namespace tsg::ros_interface
