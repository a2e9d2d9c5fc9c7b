// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <set>
#include <string>
#include <utility>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/ros/task_numbers.h"
#include "task_scene_graph/scene_graph/scene_graph.h"

namespace tsg::ros_interface {

/// How the graph is drawn: group `markers` of the scene_graph nodelet. Layers are lifted above the
/// map so that they can be told apart; boxes stay where the objects are.
struct MarkerConfig {
  double object_lift_m = 2.5;
  double place_lift_m = 4.0;
  double region_lift_m = 6.5;
  double text_height_m = 0.16;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("object_lift_m", self.object_lift_m, {0.0, 100.0}, "m",
            "how high above themselves the nodes of objects are drawn");
    v.field("place_lift_m", self.place_lift_m, {0.0, 100.0}, "m",
            "how high above themselves places are drawn");
    v.field("region_lift_m", self.region_lift_m, {0.0, 100.0}, "m",
            "how high above their centre the nodes of regions are drawn");
    v.field("text_height_m", self.text_height_m, {0.01, 10.0}, "m", "letters of labels");
  }
};

/// The scene graph as markers for rviz, a namespace for each layer and kind, so that they can be
/// switched on and off one by one: object_boxes, object_frames, object_nodes, object_labels,
/// object_edges, places, place_edges, regions, region_labels, region_edges, region_place_edges.
class SceneGraphMarkers {
 public:
  SceneGraphMarkers(const MarkerConfig& config, std::string world_frame)
      : config_(config), world_frame_(std::move(world_frame)) {}

  /// The whole picture; markers of the call before that are gone are deleted. O(graph).
  /// @param numbers  of the tasks: their colours
  visualization_msgs::MarkerArray update(const scene_graph::SceneGraph& graph,
                                         TaskNumbers& numbers);

 private:
  MarkerConfig config_;
  std::string world_frame_;
  std::set<std::pair<std::string, int>> shown_;
};

/// Colour of the i-th task or region: far apart for neighbouring i; grey for i < 0.
std_msgs::ColorRGBA computeColor(int index, float alpha);

}  // namespace tsg::ros_interface
