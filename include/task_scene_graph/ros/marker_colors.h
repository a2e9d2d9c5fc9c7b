// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <std_msgs/ColorRGBA.h>

#include <map>

#include "task_scene_graph/scene_graph/scene_graph.h"

namespace tsg::ros_interface {

/// Colour of the i-th task: far apart for neighbouring i; grey for i < 0.
std_msgs::ColorRGBA computeColor(int index, float alpha);

constexpr int kNumRegionColors = 12;
/// Paler than those of tasks, and different for kNumRegionColors indices in a row; grey for i < 0.
std_msgs::ColorRGBA computeRegionColor(int index, float alpha);
/// For a region that has no colour: the one of which least is near, by the sum of 1 / distance^2
/// (equal: the first from its id on). O(regions).
/// @param colors  of regions; those that the graph does not have do not count
int chooseRegionColor(const scene_graph::SceneGraph& graph, const scene_graph::Region& region,
                      const std::map<RegionId, int>& colors);

/// From blue (0) over cyan, green and yellow to red (1); beyond as at the ends.
std_msgs::ColorRGBA computeScoreColor(double part, float alpha);

}  // namespace tsg::ros_interface
