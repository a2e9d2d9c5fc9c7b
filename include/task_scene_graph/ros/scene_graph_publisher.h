// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <cstdint>
#include <functional>
#include <mutex>
#include <string>

#include "task_scene_graph/ros/late_subscribers.h"
#include "task_scene_graph/ros/messages.h"
#include "task_scene_graph/ros/scene_graph_markers.h"
#include "task_scene_graph/ros/stage_report.h"
#include "task_scene_graph/scene_graph/scene_graph.h"

namespace tsg::ros_interface {

/// The scene graph on three topics: `scene_graph`, whole and latched; `scene_graph_changes`,
/// numbered, of which a late subscriber is first sent the whole; `scene_graph_markers`, what
/// changed in the picture, of which a late subscriber is first sent all. Where the package
/// vision_msgs was found, the objects also as `detections`, latched.
class SceneGraphPublisher {
 public:
  struct Options {
    std::string world_frame;
    bool with_embeddings = false;
    MarkerConfig markers;
  };

  /// @param report  must outlive this object
  SceneGraphPublisher(ros::NodeHandle& handle, StageReport& report, const Options& options);
  ~SceneGraphPublisher() { stop(); }

  /// Tells of a graph. From one thread. O(graph), but what is sent of `scene_graph_changes` and
  /// `scene_graph_markers` is as large as what changed.
  /// @param numbers  of the tasks: their colours
  void publish(const scene_graph::SceneGraphPtr& graph, TaskNumbers& numbers);
  /// Draws the newest graph anew, if the configuration is another. From the same thread.
  void setMarkerConfig(const MarkerConfig& config, TaskNumbers& numbers);
  /// Subscribers that come from now on are sent nothing.
  void stop() { late_.stop(); }

 private:
  static constexpr std::uint32_t kQueueSize = 100;

  void publishMarkers(TaskNumbers& numbers);
  void sendGraph(PartSender& sender);
  void sendWholeGraph(PartSender& sender);
  void sendAllMarkers(PartSender& sender);

  const Options options_;
  std::mutex mutex_;  ///< guards the four below, and the order of what is sent of them
  scene_graph::SceneGraphPtr graph_;
  msg::SceneGraphConstPtr message_;  ///< of the graph
  std::uint64_t sequence_ = 0;
  SceneGraphMarkers markers_;
  LateSubscribers late_;
  ros::Publisher whole_publisher_;
  ros::Publisher changes_publisher_;
  ros::Publisher markers_publisher_;
  std::function<void(const scene_graph::SceneGraph&, TaskNumbers&)>
      publish_detections_;  ///< with vision_msgs only
};

}  // namespace tsg::ros_interface
