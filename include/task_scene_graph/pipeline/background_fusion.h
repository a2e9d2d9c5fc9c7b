// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/mapping/background_map.h"
#include "task_scene_graph/mapping/depth_filter.h"
#include "task_scene_graph/mapping/occupancy_map.h"
#include "task_scene_graph/places/places_config.h"

namespace tsg::pipeline {

struct BackgroundFusionConfig {
  mapping::DepthFilterConfig depth_filter;
  mapping::BackgroundConfig background;
  /// The coarse volume in which places are found: all space along every ray is observed.
  mapping::BackgroundConfig free_space = makeFreeSpaceDefaults();
  mapping::OccupancyConfig occupancy;
  places::PlacesConfig places;
  double places_period_s = 1.0;

  static mapping::BackgroundConfig makeFreeSpaceDefaults();

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.group("depth_filter", self.depth_filter);
    v.group("background", self.background);
    v.group("free_space", self.free_space);
    v.group("occupancy", self.occupancy);
    v.group("places", self.places);
    v.field("places_period_s", self.places_period_s, {0.0, 3600.0}, "s",
            "least time (of the frames' stamps) between two updates of the place graph");
  }
};

/// The maps that every posed depth image feeds. Whoever owns them filters each frame, and then lets
/// each map take it in. Not thread-safe: one thread owns them.
struct BackgroundFusion {
  explicit BackgroundFusion(const BackgroundFusionConfig& config);

  /// The frame with its depth filtered, for all the maps. O(pixels).
  /// @throws std::invalid_argument as RgbdFrame::validate().
  RgbdFramePtr filter(const RgbdFrame& frame);

  mapping::DepthFilter depth_filter;
  mapping::BackgroundMap surface;
  mapping::BackgroundMap free_space;  ///< its changed blocks are what places::PlaceExtractor wants
};

}  // namespace tsg::pipeline
