// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <std_srvs/Trigger.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>

#include "graph_access.h"
#include "task_scene_graph/language/word_encoder.h"
#include "task_scene_graph/ros/messages.h"
#include "task_scene_graph/ros/state_publisher.h"
#include "task_scene_graph/ros/task_numbers.h"
#include "task_scene_graph/scene_graph/task_changes.h"

namespace tsg::nodelets {

/// Tasks that change while the map grows: services `~change_tasks`, `~reload_tasks`, latched topic
/// `~tasks`. Calls are served one after another; a change is all or nothing.
class TaskServices {
 public:
  struct Files {
    std::filesystem::path objects;
    std::filesystem::path places;  ///< empty: the places' tasks are the objects'
  };

  /// @param services  whose callbacks run in a thread of their own, one at a time
  TaskServices(ros::NodeHandle& services, GraphAccess access,
               std::shared_ptr<language::WordEncoder> encoder, const Files& files);

  /// Says what holds, if that or what serves it has changed. Of the builder's thread.
  void publish(const scene_graph::SceneGraph& graph);
  /// Ids of tasks, and from them colours. Of the builder's thread.
  ros_interface::TaskNumbers& numbers() { return numbers_; }

 private:
  bool serveChange(msg::ChangeTasksRequest& request, msg::ChangeTasksResponse& response);
  bool serveReload(std_srvs::TriggerRequest& request, std_srvs::TriggerResponse& response);
  scene_graph::TaskChange readChange(const msg::ChangeTasksRequest& request);
  EmbeddingMatrix readEmbeddings(const std::vector<msg::Task>& tasks);
  void change(const scene_graph::TaskChange& change, bool is_for_places);
  msg::TasksInForce describe(const scene_graph::SceneGraph& graph);
  msg::TasksInForce inForce() const;

  GraphAccess access_;
  std::shared_ptr<language::WordEncoder> encoder_;
  Files files_;
  std::atomic<bool> places_follow_objects_;
  bool is_first_ = true;                ///< nothing was published yet; of the builder's thread
  ros_interface::TaskNumbers numbers_;  ///< of the builder's thread
  ros_interface::StatePublisher<msg::TasksInForce> publisher_;
  mutable std::mutex mutex_;  ///< guards the two below
  msg::TasksInForce in_force_;
  bool has_published_ = false;
  std::vector<ros::ServiceServer> servers_;
};

}  // namespace tsg::nodelets
