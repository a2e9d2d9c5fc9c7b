// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nav_msgs/Path.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <task_scene_graph/PlanPath.h>

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/places/ground_plan.h"
#include "task_scene_graph/planning/planner.h"
#include "task_scene_graph/ros/late_subscribers.h"
#include "task_scene_graph/ros/messages.h"
#include "task_scene_graph/ros/stage_report.h"
#include "task_scene_graph/ros/state_publisher.h"
#include "task_scene_graph/ros/storey_publisher.h"

namespace tsg::nodelets {

/// Places and their ground plan -> the storeys' grids, and the service `plan_path`, in a thread of
/// its own. Objects and regions are looked up in the newest `scene_graph`. Thread-safe.
class NavigationStage {
 public:
  struct Options {
    planning::PlannerConfig planner;
    std::string world_frame;
  };

  /// Advertises `plan_path` (service), `path` and, as storeys are found, `floor_<n>/map...`;
  /// subscribes to `scene_graph`.
  /// @param report  must outlive this object
  NavigationStage(const ros::NodeHandle& handle, const Options& options,
                  ros_interface::StageReport& report);
  ~NavigationStage() { stop(); }

  /// Where the camera is now; world frame.
  void setCamera(const Eigen::Vector3d& position_m);
  void forgetCamera();
  /// The map to plan in from now on. O(places + tiles of the plan), but for the grids.
  void setMap(const PlaceGraph& places, const places::GroundPlan& plan);
  /// As they are published.
  std::vector<planning::StoreyGrid> storeys() const { return storeys_.storeys(); }
  /// Serves nobody any more.
  void stop();

 private:
  using Request = msg::PlanPathRequest;
  using Response = msg::PlanPathResponse;

  /// What is planned in; immutable.
  struct Map {
    PlaceGraph places;  ///< without embeddings
    places::GroundPlan plan;
    std::shared_ptr<const planning::Planner> planner;  ///< made when it is first asked for
  };

  void onSceneGraph(const msg::SceneGraphConstPtr& message);
  bool servePlan(Request& request, Response& response);
  void plan(const Request& request, Response& response);
  std::shared_ptr<const planning::Planner> planner();
  Eigen::Vector3d findStart(const Request& request) const;
  planning::Goal findGoal(const Request& request, Response& response) const;

  const Options options_;
  ros_interface::LateSubscribers late_;
  ros_interface::StoreyPublisher storeys_;
  mutable std::mutex mutex_;  ///< guards the four below; never held while planning
  std::optional<Eigen::Vector3d> camera_m_;
  Map map_;
  std::uint64_t num_maps_ = 0;
  msg::SceneGraphConstPtr graph_;
  ros::CallbackQueue queue_;
  ros::NodeHandle handle_;  ///< whose callbacks `spinner_` calls
  ros_interface::StatePublisher<nav_msgs::Path> path_publisher_;
  ros::Subscriber graph_subscriber_;
  ros::ServiceServer server_;
  ros::AsyncSpinner spinner_;
};

}  // namespace tsg::nodelets
