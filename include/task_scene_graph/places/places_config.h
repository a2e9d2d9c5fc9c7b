// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/config/visitor.h"

namespace tsg::places {

/// What counts as free, and in which directions clearance is measured.
enum class FreeSpaceKind {
  kWalkable,  ///< where a body of body_height_m can stand; clearance is horizontal
  kVolume     ///< every observed free voxel; clearance is three-dimensional
};

/// How much each view that sees a place counts for its feature.
enum class ViewWeighting {
  kAverage,       ///< all the same [Clio24, Sec. IV-A]
  kClosest,       ///< only the nearest one [Clio24, Sec. V-C, Clio (closest)]
  kInverseSquare  ///< by the solid angle under which it is seen
};

/// deviation: upstream looks 3 m far and keeps places 0.4 m from obstacles; here 5 m, since a
/// ground plan costs little and halls are wide, and 0.3 m, since the middle of a 0.8 m door in 0.1
/// m voxels may have no more than that. Its places are about 1 m apart; here 0.5 m, so that their
/// spheres reach into the corners of a room and regions can be rooms (docs/places.md).
struct PlacesConfig {
  FreeSpaceKind free_space = FreeSpaceKind::kWalkable;
  double body_height_m = 1.2;
  double body_radius_m = 0.25;
  double camera_height_m = 0.0;
  double max_way_gap_m = 1.0;
  double max_step_m = 0.2;
  double min_floor_area_m2 = 4.0;
  double max_floor_gap_m = 0.5;
  double max_distance_m = 5.0;
  double min_clearance_m = 0.3;
  double min_parent_separation_m = 2.5;
  double max_parent_cosine = 0.1;
  double cell_size_m = 0.5;
  double merge_distance_m = 0.25;
  double fill_distance_m = 0.4;
  double min_edge_clearance_m = 0.25;
  double max_edge_m = 2.2;
  double edge_stretch = 1.1;
  int min_component_size = 12;
  double max_view_range_m = 5.0;
  double occlusion_tolerance_m = 0.1;
  int max_views = 4000;
  /// deviation: the paper averages; but a whole image says more of what is near, and what looks
  /// into a room through its door then names the room (docs/places.md has the numbers).
  ViewWeighting view_weighting = ViewWeighting::kInverseSquare;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.choice("free_space", self.free_space,
             {{"walkable", FreeSpaceKind::kWalkable}, {"volume", FreeSpaceKind::kVolume}},
             "walkable = above observed floor (world z up), clearance horizontal; volume = all "
             "observed free space, clearance in 3D");
    v.field("body_height_m", self.body_height_m, {0.1, 3.0}, "m",
            "walkable: height above the floor that must be observed free");
    v.field("body_radius_m", self.body_radius_m, {0.05, 2.0}, "m",
            "what the body that carries the camera covers is floor (volume: free) unless something "
            "solid was seen there");
    v.field("camera_height_m", self.camera_height_m, {0.0, 10.0}, "m",
            "walkable: of the camera above the floor; 0 = estimated from the floor that is seen "
            "around it");
    v.field("max_way_gap_m", self.max_way_gap_m, {0.0, 100.0}, "m",
            "consecutive poses farther apart are a jump, not a way; 0 = the way is not used");
    v.field("max_step_m", self.max_step_m, {0.05, 1.0}, "m",
            "walkable: floor may rise by this from voxel to voxel; what is lower is no obstacle");
    v.field("min_floor_area_m2", self.min_floor_area_m2, {0.0, 1000.0}, "m2",
            "walkable: connected floors that are smaller are left out (table tops, beds)");
    v.field("max_floor_gap_m", self.max_floor_gap_m, {0.0, 5.0}, "m",
            "walkable: floor that was not seen is taken for granted this near to floor that was, "
            "where the upper half of a body was observed free");
    v.field("max_distance_m", self.max_distance_m, {0.5, 20.0}, "m",
            "obstacles farther away are not looked for");
    v.field("min_clearance_m", self.min_clearance_m, {0.0, 5.0}, "m",
            "least distance of a place to the nearest observed obstacle");
    v.field("min_parent_separation_m", self.min_parent_separation_m, {0.0, 20.0}, "m",
            "a Voronoi voxel has two nearest obstacles so far apart (L1) ...");
    v.field("max_parent_cosine", self.max_parent_cosine, {-1.0, 1.0}, "",
            "... or seen from it under an angle whose cosine is below this");
    v.field("cell_size_m", self.cell_size_m, {0.2, 10.0}, "m",
            "a connected set of Voronoi voxels in a cell of this size becomes a place");
    v.field("merge_distance_m", self.merge_distance_m, {0.0, 10.0}, "m",
            "places that touch and are nearer than this become one");
    v.field("fill_distance_m", self.fill_distance_m, {0.0, 10.0}, "m",
            "walkable: cells with open space farther than this (at most a cell) from all places "
            "get a place as well; 0 = only Voronoi places");
    v.field("min_edge_clearance_m", self.min_edge_clearance_m, {0.0, 5.0}, "m",
            "least clearance along the straight line of an edge");
    v.field("max_edge_m", self.max_edge_m, {0.5, 10.0}, "m",
            "edges join places at most so far apart, along free straight lines ...");
    v.field("edge_stretch", self.edge_stretch, {1.0, 2.0}, "",
            "... unless a way over a third place is at most so many times as long");
    v.field("min_component_size", self.min_component_size, {1, 1000}, "",
            "connected parts that meet fewer cells are left out, unless the body was there");
    v.field("max_view_range_m", self.max_view_range_m, {0.1, 100.0}, "m",
            "views see places up to this distance");
    v.field("occlusion_tolerance_m", self.occlusion_tolerance_m, {0.0, 5.0}, "m",
            "a place farther behind the measured depth is hidden");
    v.field("max_views", self.max_views, {1, 1000000}, "",
            "views kept for places yet to come; the oldest is forgotten first");
    v.choice("view_weighting", self.view_weighting,
             {{"average", ViewWeighting::kAverage},
              {"closest", ViewWeighting::kClosest},
              {"inverse_square", ViewWeighting::kInverseSquare}},
             "what a view counts for a place that it sees: all the same (the paper), the nearest "
             "alone, or by the inverse square of its distance");
  }
};

}  // namespace tsg::places
