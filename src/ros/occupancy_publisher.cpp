// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/occupancy_publisher.h"

#include <algorithm>
#include <vector>

#include "task_scene_graph/core/period.h"
#include "task_scene_graph/ros/occupancy_conversions.h"

namespace tsg::ros_interface {
namespace {

constexpr std::size_t kVoxelsPerPart = 70000;  // 13 bytes each: just below 1 MB

}  // namespace

OccupancyPublisher::OccupancyPublisher(ros::NodeHandle& handle, LateSubscribers& late,
                                       const Options& options, mapping::OccupancyMap& map,
                                       std::mutex& map_mutex)
    : options_(options),
      map_(map),
      map_mutex_(map_mutex),
      map_publisher_(late.advertise<OctomapMessage>(handle, "octomap", 2,
                                                    [this](PartSender& s) { serveMap(s); })),
      changes_publisher_(late.advertise<msg::OctomapChanges>(
          handle, "octomap_changes", 100, [this](PartSender& s) { serveVoxels(s); })),
      markers_publisher_(late.advertise<visualization_msgs::MarkerArray>(
          handle, "octomap_markers", 2, [this](PartSender& s) { serveMarkers(s); })) {}

void OccupancyPublisher::publish(Stamp stamp, bool force) {
  if (!isDue(last_, stamp, options_.period_s) && !force) return;
  last_ = stamp;
  publishChanges();
  if (is_whole_due_) publishAll();
}

void OccupancyPublisher::publishChanges() {
  const auto changes = map_.takeChanges();
  if (changes.empty()) return;
  is_whole_due_ = true;
  if (changes_publisher_.getNumSubscribers() == 0) return;
  changes_publisher_.publish(
      toMessage(changes, map_.config().resolution_m, false, *last_, options_.world_frame));
}

void OccupancyPublisher::publishAll() {
  is_whole_due_ = false;
  if (map_publisher_.getNumSubscribers() > 0) {
    map_publisher_.publish(toMessage(map_, *last_, options_.world_frame));
  }
  if (markers_publisher_.getNumSubscribers() > 0) {
    markers_publisher_.publish(toMarkers(map_, options_.world_frame));
  }
}

void OccupancyPublisher::clear(Stamp stamp) {
  ++num_clears_;
  last_ = stamp;
  changes_publisher_.publish(
      toMessage({}, map_.config().resolution_m, true, stamp, options_.world_frame));
  publishAll();
}

void OccupancyPublisher::replace(Stamp stamp) {
  clear(stamp);
  const auto voxels = map_.voxels();
  for (std::size_t first = 0; first < voxels.size(); first += kVoxelsPerPart) {
    const std::size_t end = std::min(voxels.size(), first + kVoxelsPerPart);
    const std::vector<mapping::OccupancyVoxel> part(
        voxels.begin() + static_cast<std::ptrdiff_t>(first),
        voxels.begin() + static_cast<std::ptrdiff_t>(end));
    changes_publisher_.publish(
        toMessage(part, map_.config().resolution_m, false, stamp, options_.world_frame));
  }
}

void OccupancyPublisher::serveMap(PartSender& sender) {
  const std::lock_guard<std::mutex> lock(map_mutex_);
  if (last_) sender.send(toMessage(map_, *last_, options_.world_frame));
}

void OccupancyPublisher::serveMarkers(PartSender& sender) {
  const std::lock_guard<std::mutex> lock(map_mutex_);
  if (last_) sender.send(toMarkers(map_, options_.world_frame));
}

void OccupancyPublisher::serveVoxels(PartSender& sender) {
  std::unique_lock<std::mutex> lock(map_mutex_);
  if (!last_) return;
  const auto clears = num_clears_;
  const auto voxels = map_.voxels();
  for (std::size_t first = 0; first == 0 || first < voxels.size(); first += kVoxelsPerPart) {
    const std::size_t end = std::min(voxels.size(), first + kVoxelsPerPart);
    // Else a voxel that this part shows as changed, and that changes back before the next message,
    // would stay changed for this subscriber.
    publishChanges();
    std::vector<mapping::OccupancyVoxel> part;
    for (std::size_t i = first; i < end; ++i) {
      // As it is now: what is sent to all meanwhile may come before it, never after.
      const auto now = map_.atVoxel(voxels[i].index);
      part.push_back({voxels[i].index, now == mapping::Occupancy::kOccupied});
    }
    sender.send(
        toMessage(part, map_.config().resolution_m, first == 0, *last_, options_.world_frame));
    lock.unlock();
    if (!sender.waitForRoom()) return;
    lock.lock();
    if (clears != num_clears_) return;
  }
}

}  // namespace tsg::ros_interface
