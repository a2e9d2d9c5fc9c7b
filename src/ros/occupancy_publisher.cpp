// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/occupancy_publisher.h"

#include <ros/publisher.h>
#include <ros/single_subscriber_publisher.h>

#include "task_scene_graph/core/period.h"
#include "task_scene_graph/ros/occupancy_conversions.h"

namespace tsg::ros_interface {

OccupancyPublisher::OccupancyPublisher(ros::NodeHandle& handle, const Options& options,
                                       mapping::OccupancyMap& map, std::mutex& map_mutex)
    : options_(options),
      map_(map),
      map_mutex_(map_mutex),
      map_publisher_(
          handle.advertise<OctomapMessage>("octomap", 2, greet(&OccupancyPublisher::sendMap))),
      changes_publisher_(handle.advertise<msg::OctomapChanges>(
          "octomap_changes", 100, greet(&OccupancyPublisher::sendVoxels))),
      markers_publisher_(handle.advertise<visualization_msgs::MarkerArray>(
          "octomap_markers", 2, greet(&OccupancyPublisher::sendMarkers))) {}

void OccupancyPublisher::publish(Stamp stamp, bool force) {
  if (!isDue(last_, stamp, options_.period_s) && !force) return;
  last_ = stamp;
  const auto changes = map_.takeChanges();
  if (changes.empty()) return;
  if (changes_publisher_.getNumSubscribers() > 0) {
    changes_publisher_.publish(
        toMessage(changes, map_.config().resolution_m, false, stamp, options_.world_frame));
  }
  if (map_publisher_.getNumSubscribers() > 0) {
    map_publisher_.publish(toMessage(map_, stamp, options_.world_frame));
  }
  if (markers_publisher_.getNumSubscribers() > 0) {
    markers_publisher_.publish(toMarkers(map_, options_.world_frame));
  }
}

ros::SubscriberStatusCallback OccupancyPublisher::greet(
    void (OccupancyPublisher::*send)(const ros::SingleSubscriberPublisher&)) {
  return [this, send](const ros::SingleSubscriberPublisher& subscriber) {
    const std::lock_guard<std::mutex> lock(map_mutex_);
    if (last_) (this->*send)(subscriber);
  };
}

void OccupancyPublisher::sendMap(const ros::SingleSubscriberPublisher& subscriber) {
  subscriber.publish(toMessage(map_, *last_, options_.world_frame));
}

void OccupancyPublisher::sendVoxels(const ros::SingleSubscriberPublisher& subscriber) {
  subscriber.publish(
      toMessage(map_.voxels(), map_.config().resolution_m, true, *last_, options_.world_frame));
}

void OccupancyPublisher::sendMarkers(const ros::SingleSubscriberPublisher& subscriber) {
  subscriber.publish(toMarkers(map_, options_.world_frame));
}

}  // namespace tsg::ros_interface
