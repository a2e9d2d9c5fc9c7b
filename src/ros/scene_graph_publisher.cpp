// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/scene_graph_publisher.h"

#include <visualization_msgs/MarkerArray.h>

#ifdef TSG_WITH_VISION_MSGS
#include <vision_msgs/Detection3DArray.h>
#endif

#include "task_scene_graph/ros/detections.h"
#include "task_scene_graph/ros/scene_graph_changes.h"
#include "task_scene_graph/ros/scene_graph_conversions.h"
#include "task_scene_graph/ros/state_publisher.h"

namespace tsg::ros_interface {

SceneGraphPublisher::SceneGraphPublisher(ros::NodeHandle& handle, StageReport& report,
                                         const Options& options)
    : options_(options),
      markers_(options.markers, options.world_frame),
      late_(report),
      whole_publisher_(late_.advertise<msg::SceneGraph>(
          handle, "scene_graph", kQueueSize, [this](PartSender& sender) { sendGraph(sender); })),
      changes_publisher_(late_.advertise<msg::SceneGraphChanges>(
          handle, "scene_graph_changes", kQueueSize,
          [this](PartSender& sender) { sendWholeGraph(sender); })),
      markers_publisher_(late_.advertise<visualization_msgs::MarkerArray>(
          handle, "scene_graph_markers", kQueueSize,
          [this](PartSender& sender) { sendAllMarkers(sender); })) {
#ifdef TSG_WITH_VISION_MSGS
  const StatePublisher<vision_msgs::Detection3DArray> publisher(handle, "detections");
  publish_detections_ = [publisher](const scene_graph::SceneGraph& graph, TaskNumbers& numbers) {
    publisher.publish(toDetections<vision_msgs::Detection3DArray>(graph, numbers));
  };
#endif
}

void SceneGraphPublisher::publish(const scene_graph::SceneGraphPtr& graph, TaskNumbers& numbers) {
  const msg::SceneGraphConstPtr message =
      toMessage(*graph, options_.world_frame, options_.with_embeddings);
  if (publish_detections_) publish_detections_(*graph, numbers);
  const std::lock_guard<std::mutex> lock(mutex_);
  whole_publisher_.publish(message);
  msg::SceneGraphChanges changes =
      computeChanges(message_ == nullptr ? msg::SceneGraph() : *message_, *message);
  graph_ = graph;
  message_ = message;
  changes.sequence = ++sequence_;
  if (sequence_ == 1) changes.is_whole = 1;
  changes_publisher_.publish(changes);
  publishMarkers(numbers);
}

void SceneGraphPublisher::setMarkerConfig(const MarkerConfig& config, TaskNumbers& numbers) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (config == markers_.config()) return;
  markers_.setConfig(config);
  if (graph_ != nullptr) publishMarkers(numbers);
}

void SceneGraphPublisher::publishMarkers(TaskNumbers& numbers) {
  const visualization_msgs::MarkerArray markers = markers_.update(*graph_, numbers);
  if (!markers.markers.empty()) markers_publisher_.publish(markers);
}

void SceneGraphPublisher::sendGraph(PartSender& sender) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (message_ != nullptr) sender.send(*message_);
}

void SceneGraphPublisher::sendWholeGraph(PartSender& sender) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (message_ != nullptr) sender.send(toWholeGraph(*message_, sequence_));
}

void SceneGraphPublisher::sendAllMarkers(PartSender& sender) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (message_ != nullptr) sender.send(markers_.all());
}

}  // namespace tsg::ros_interface
