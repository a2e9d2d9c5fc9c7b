// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <std_msgs/ColorRGBA.h>
#include <visualization_msgs/MarkerArray.h>

#include <string>
#include <vector>

#include "task_scene_graph/mapping/occupancy_map.h"
#include "task_scene_graph/ros/messages.h"
#ifdef TSG_WITH_OCTOMAP_MSGS
#include <octomap_msgs/Octomap.h>
#endif

namespace tsg::ros_interface {

#ifdef TSG_WITH_OCTOMAP_MSGS
using OctomapMessage = octomap_msgs::Octomap;
#else
using OctomapMessage = msg::Octomap;  ///< the same fields
#endif

/// The whole tree: free, occupied and unknown.
OctomapMessage toMessage(const mapping::OccupancyMap& map, Stamp stamp,
                         const std::string& world_frame);

msg::OctomapChanges toMessage(const std::vector<mapping::OccupancyVoxel>& voxels,
                              double resolution_m, bool is_complete, Stamp stamp,
                              const std::string& world_frame);

/// Blue, green, red, blue again every four metres. @param z_m  world frame.
std_msgs::ColorRGBA computeHeightColor(double z_m);

/// Occupied space as cubes coloured by height, a CUBE_LIST for each size of cube; a size that no
/// cube has gets a marker that deletes what was there.
visualization_msgs::MarkerArray toMarkers(const mapping::OccupancyMap& map,
                                          const std::string& world_frame);

}  // namespace tsg::ros_interface
