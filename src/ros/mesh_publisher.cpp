// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/mesh_publisher.h"

#include <ros/publisher.h>
#include <ros/single_subscriber_publisher.h>

#include "task_scene_graph/core/period.h"

namespace tsg::ros_interface {

MeshPublisher::MeshPublisher(ros::NodeHandle& handle, const Options& options,
                             pipeline::BackgroundFusion& fusion, std::mutex& fusion_mutex)
    : options_(options),
      fusion_(fusion),
      fusion_mutex_(fusion_mutex),
      markers_(options.world_frame),
      blocks_(options.world_frame, fusion.background().volume().voxelSize() * mapping::kBlockSide),
      markers_publisher_(handle.advertise<visualization_msgs::MarkerArray>(
          "mesh", 1000, [this](const auto& subscriber) { greetMarkers(subscriber); })),
      blocks_publisher_(handle.advertise<msg::MeshUpdate>(
          "mesh_blocks", 1000, [this](const auto& subscriber) { greetBlocks(subscriber); })) {}

void MeshPublisher::publish(Stamp stamp, bool force) {
  if (!isDue(last_, stamp, options_.period_s) && !force) return;
  last_ = stamp;
  const mapping::MeshUpdate update = fusion_.updateMesh();
  if (markers_publisher_.getNumSubscribers() == 0) {
    markers_.note(update);
  } else {
    for (const auto& message : markers_.update(update, meshFinder())) {
      markers_publisher_.publish(message);
    }
  }
  if (blocks_publisher_.getNumSubscribers() == 0) {
    blocks_.skip();
  } else {
    blocks_.sendChanges(update, stamp,
                        [&](const msg::MeshUpdate& part) { blocks_publisher_.publish(part); });
  }
}

FindMesh MeshPublisher::meshFinder() const {
  return [this](const mapping::GridIndex& block) { return fusion_.background().findMesh(block); };
}

void MeshPublisher::greetMarkers(const ros::SingleSubscriberPublisher& subscriber) {
  const std::lock_guard<std::mutex> lock(fusion_mutex_);
  for (const auto& message : markers_.all(meshFinder())) subscriber.publish(message);
}

void MeshPublisher::greetBlocks(const ros::SingleSubscriberPublisher& subscriber) {
  const std::lock_guard<std::mutex> lock(fusion_mutex_);
  blocks_.sendAll(fusion_.background().meshBlocks(), meshFinder(), last_.value_or(Stamp{}),
                  [&](const msg::MeshUpdate& part) { subscriber.publish(part); });
}

}  // namespace tsg::ros_interface
