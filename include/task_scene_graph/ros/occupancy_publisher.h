// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <mutex>
#include <optional>
#include <string>

#include "task_scene_graph/mapping/occupancy_map.h"

namespace tsg::ros_interface {

/// Publishes an occupancy map: `octomap` (whole), `octomap_changes` and `octomap_markers`. Nothing
/// is made that nobody listens to; a late subscriber is first sent all there is.
class OccupancyPublisher {
 public:
  struct Options {
    std::string world_frame;
    double period_s = 1.0;  ///< least time, of the frames' stamps, between two messages
  };

  /// @param map        must outlive this object.
  /// @param map_mutex  guards the map; locked when a subscriber comes.
  OccupancyPublisher(ros::NodeHandle& handle, const Options& options, mapping::OccupancyMap& map,
                     std::mutex& map_mutex);

  /// Publishes what is due at `stamp` (or `force`). Precondition: the caller holds map_mutex.
  void publish(Stamp stamp, bool force);

 private:
  ros::SubscriberStatusCallback greet(
      void (OccupancyPublisher::*send)(const ros::SingleSubscriberPublisher&));
  void sendMap(const ros::SingleSubscriberPublisher& subscriber);
  void sendVoxels(const ros::SingleSubscriberPublisher& subscriber);
  void sendMarkers(const ros::SingleSubscriberPublisher& subscriber);

  Options options_;
  mapping::OccupancyMap& map_;
  std::mutex& map_mutex_;
  std::optional<Stamp> last_;
  ros::Publisher map_publisher_;
  ros::Publisher changes_publisher_;
  ros::Publisher markers_publisher_;
};

}  // namespace tsg::ros_interface
