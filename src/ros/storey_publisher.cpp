// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/storey_publisher.h"

#include <map_msgs/OccupancyGridUpdate.h>
#include <nav_msgs/OccupancyGrid.h>

#include <boost/make_shared.hpp>
#include <utility>

#include "task_scene_graph/ros/geometry_conversions.h"

namespace tsg::ros_interface {
namespace {

using planning::StoreyChange;
using planning::StoreyGrid;

nav_msgs::OccupancyGridPtr toMessage(const StoreyGrid& grid, const std::string& world_frame,
                                     Stamp stamp) {
  auto message = boost::make_shared<nav_msgs::OccupancyGrid>();
  message->header.frame_id = world_frame;
  message->header.stamp = toRosTime(stamp);
  message->info.map_load_time = message->header.stamp;
  message->info.resolution = static_cast<float>(grid.cell_size_m);
  message->info.width = static_cast<std::uint32_t>(grid.width);
  message->info.height = static_cast<std::uint32_t>(grid.height);
  message->info.origin.position.x = grid.min.first * grid.cell_size_m;
  message->info.origin.position.y = grid.min.second * grid.cell_size_m;
  message->info.origin.position.z = grid.floor_m;
  message->info.origin.orientation.w = 1.0;
  message->data = grid.cells;
  return message;
}

map_msgs::OccupancyGridUpdatePtr toMessage(const StoreyGrid& grid, const StoreyChange& change,
                                           const std::string& world_frame, Stamp stamp) {
  auto message = boost::make_shared<map_msgs::OccupancyGridUpdate>();
  message->header.frame_id = world_frame;
  message->header.stamp = toRosTime(stamp);
  message->x = change.min.first - grid.min.first;
  message->y = change.min.second - grid.min.second;
  message->width = static_cast<std::uint32_t>(change.width);
  message->height = static_cast<std::uint32_t>(change.height);
  for (int y = 0; y < change.height; ++y) {
    for (int x = 0; x < change.width; ++x) {
      message->data.push_back(grid.at({change.min.first + x, change.min.second + y}));
    }
  }
  return message;
}

}  // namespace

StoreyPublisher::StoreyPublisher(const ros::NodeHandle& handle, LateSubscribers& late,
                                 std::string world_frame)
    : handle_(handle), late_(late), world_frame_(std::move(world_frame)) {}

void StoreyPublisher::update(const places::GroundPlan& plan, Stamp stamp) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::vector<StoreyChange> changes = map_.update(plan);
  stamp_ = stamp;
  while (topics_.size() < map_.storeys().size()) advertise(topics_.size());
  for (const StoreyChange& change : changes) {
    const StoreyGrid& grid = map_.storeys()[change.storey];
    const Topics& topics = topics_[change.storey];
    const bool all_follow = topics.updates.getNumSubscribers() > 0 &&
                            topics.updates.getNumSubscribers() >= topics.map.getNumSubscribers();
    if (change.is_whole || !all_follow) topics.map.publish(toMessage(grid, world_frame_, stamp));
    if (!change.is_whole && topics.updates.getNumSubscribers() > 0) {
      topics.updates.publish(toMessage(grid, change, world_frame_, stamp));
    }
  }
}

void StoreyPublisher::advertise(std::size_t storey) {
  const std::string topic = "floor_" + std::to_string(storey) + "/map";
  Topics topics;
  constexpr bool kIsLatched = true;  // for subscribers in this process, whom `late_` is not told of
  topics.map = late_.advertise<nav_msgs::OccupancyGrid>(
      handle_, topic, 2, [this, storey](PartSender& sender) { serve(storey, sender); }, kIsLatched);
  topics.updates = handle_.advertise<map_msgs::OccupancyGridUpdate>(topic + "_updates", 100);
  topics_.push_back(topics);
}

void StoreyPublisher::serve(std::size_t storey, PartSender& sender) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (storey >= map_.storeys().size()) return;
  sender.send(*toMessage(map_.storeys()[storey], world_frame_, stamp_));
}

std::vector<StoreyGrid> StoreyPublisher::storeys() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return map_.storeys();
}

}  // namespace tsg::ros_interface
