// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include "task_scene_graph/mapping/occupancy_map.h"
#include "task_scene_graph/ros/late_subscribers.h"

namespace tsg::ros_interface {

/// Publishes an occupancy map: `octomap` (whole), `octomap_changes` and `octomap_markers`. Nothing
/// is made that nobody listens to. A late subscriber of the changes is first sent all there is,
/// part by part; the other two are whole by their nature.
class OccupancyPublisher {
 public:
  struct Options {
    std::string world_frame;
    double period_s = 1.0;  ///< least time, of the frames' stamps, between two messages
  };

  /// @param late       serves late subscribers; must outlive this object
  /// @param map        must outlive this object.
  /// @param map_mutex  guards the map; locked when a subscriber comes, once for each part.
  OccupancyPublisher(ros::NodeHandle& handle, LateSubscribers& late, const Options& options,
                     mapping::OccupancyMap& map, std::mutex& map_mutex);

  /// Publishes what is due at `stamp` (or `force`). Precondition: the caller holds map_mutex.
  void publish(Stamp stamp, bool force);
  /// Tells subscribers that the map is empty now. Precondition: it is, and the caller holds
  /// map_mutex.
  void clear(Stamp stamp);
  /// Tells subscribers that the map is another one now. Precondition: the caller holds map_mutex.
  void replace(Stamp stamp);

 private:
  /// Precondition: something was published or cleared before.
  void publishChanges();
  void publishAll();
  void serveMap(PartSender& sender);
  void serveMarkers(PartSender& sender);
  void serveVoxels(PartSender& sender);

  Options options_;
  mapping::OccupancyMap& map_;
  std::mutex& map_mutex_;  ///< guards the three below, too
  std::optional<Stamp> last_;
  std::uint64_t num_clears_ = 0;
  bool is_whole_due_ = false;  ///< whether changes were published since publishAll()
  ros::Publisher map_publisher_;
  ros::Publisher changes_publisher_;
  ros::Publisher markers_publisher_;
};

}  // namespace tsg::ros_interface
