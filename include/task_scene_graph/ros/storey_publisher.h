// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <mutex>
#include <string>
#include <vector>

#include "task_scene_graph/core/stamp.h"
#include "task_scene_graph/planning/storeys.h"
#include "task_scene_graph/ros/late_subscribers.h"

namespace tsg::ros_interface {

/// Publishes each storey of a ground plan as move_base's static layer and map_saver take it:
/// `floor_<n>/map` (nav_msgs/OccupancyGrid, latched) and `floor_<n>/map_updates`
/// (map_msgs/OccupancyGridUpdate). While somebody takes maps but no updates, each change is a whole
/// map; a late subscriber is sent the map of now. The origin's z is the height of the floor.
/// Thread-safe.
class StoreyPublisher {
 public:
  /// @param late  serves late subscribers; must outlive this object
  StoreyPublisher(const ros::NodeHandle& handle, LateSubscribers& late, std::string world_frame);

  /// Draws and publishes what is new in the plan. O(tiles + changed tiles * 64).
  void update(const places::GroundPlan& plan, Stamp stamp);

  std::vector<planning::StoreyGrid> storeys() const;

 private:
  struct Topics {
    ros::Publisher map;
    ros::Publisher updates;
  };

  void advertise(std::size_t storey);
  void serve(std::size_t storey, PartSender& sender) const;

  ros::NodeHandle handle_;
  LateSubscribers& late_;
  const std::string world_frame_;
  mutable std::mutex mutex_;  ///< guards all below; held while a message is made and queued
  planning::StoreyMap map_;
  Stamp stamp_;
  std::vector<Topics> topics_;
};

}  // namespace tsg::ros_interface
