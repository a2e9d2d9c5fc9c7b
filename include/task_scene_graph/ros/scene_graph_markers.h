// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/ros/marker_colors.h"
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
  double label_distance_m = 1.0;

  friend bool operator==(const MarkerConfig& a, const MarkerConfig& b) {
    return a.object_lift_m == b.object_lift_m && a.place_lift_m == b.place_lift_m &&
           a.region_lift_m == b.region_lift_m && a.text_height_m == b.text_height_m &&
           a.label_distance_m == b.label_distance_m;
  }

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("object_lift_m", self.object_lift_m, {0.0, 100.0}, "m",
            "how high above themselves the nodes of objects are drawn");
    v.field("place_lift_m", self.place_lift_m, {0.0, 100.0}, "m",
            "how high above themselves places are drawn");
    v.field("region_lift_m", self.region_lift_m, {0.0, 100.0}, "m",
            "how high above their centre the nodes of regions are drawn");
    v.field("text_height_m", self.text_height_m, {0.01, 10.0}, "m", "letters of labels");
    v.field("label_distance_m", self.label_distance_m, {0.0, 100.0}, "m",
            "objects of one task that are no farther apart have one label, with their number");
  }
};

/// The scene graph as markers for rviz, a namespace for each layer and kind, so that they can be
/// switched on and off one by one: object_boxes, object_frames, object_nodes, object_labels (at
/// the nodes), object_box_labels (above the boxes), object_edges, object_place_edges, places,
/// place_edges, regions, region_labels, region_floors, region_outlines, region_edges,
/// region_place_edges. What there is thousands of is drawn in markers of kChunk neighbouring ids
/// each, so that a change sends little.
class SceneGraphMarkers {
 public:
  static constexpr std::uint64_t kChunk = 64;

  SceneGraphMarkers(const MarkerConfig& config, std::string world_frame)
      : config_(config), world_frame_(std::move(world_frame)) {}

  /// Draws all of the next update anew.
  void setConfig(const MarkerConfig& config);
  const MarkerConfig& config() const { return config_; }

  /// What has changed since the call before: markers that are new or look different, and those that
  /// are gone, to be deleted. O(graph), but only what changed is drawn.
  /// @param numbers  of the tasks: their colours
  visualization_msgs::MarkerArray update(const scene_graph::SceneGraph& graph,
                                         TaskNumbers& numbers);
  /// The whole picture as of the last update, for somebody who may have an older one: first all is
  /// deleted.
  visualization_msgs::MarkerArray all() const;

 private:
  /// Markers that are drawn of the same things.
  struct Group {
    std::string look;  ///< bytes of all that they are drawn of
    std::vector<visualization_msgs::Marker> markers;
    std::uint64_t update = 0;  ///< that it was last in
  };
  using GroupKey = std::pair<int, std::uint64_t>;  ///< kind, id or chunk

  void removeGone(visualization_msgs::MarkerArray& changes);
  void colorRegions(const scene_graph::SceneGraph& graph);

  MarkerConfig config_;
  std::string world_frame_;
  std::map<GroupKey, Group> groups_;
  std::map<RegionId, int> region_colors_;  ///< also of regions that went: an id keeps its colour
  std::uint64_t num_updates_ = 0;
};

}  // namespace tsg::ros_interface
