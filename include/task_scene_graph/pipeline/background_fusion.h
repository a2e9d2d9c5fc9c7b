// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/mapping/background_map.h"
#include "task_scene_graph/mapping/depth_filter.h"
#include "task_scene_graph/mapping/occupancy_map.h"
#include "task_scene_graph/places/place_extractor.h"

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

/// What every posed depth image feeds: the background mesh, the places in observed free space,
/// and where `occupancy/enabled` an occupancy map.
/// Not thread-safe: one worker owns it.
class BackgroundFusion {
 public:
  explicit BackgroundFusion(const BackgroundFusionConfig& config);

  /// Filters the depth of one frame and fuses it into every volume. O(pixels + voxels in view).
  mapping::IntegrationResult integrate(const RgbdFrame& frame);

  /// Lets the places that a frame sees take part in its image embedding.
  void addView(const RgbdFrame& frame, const Embedding& image_embedding);

  /// Blocks of the mesh that have changed since the last call.
  mapping::MeshUpdate updateMesh() { return background_.updateMesh(); }

  /// The place graph, if it is due at `now` (or `force`): places_period_s after the last one.
  PlaceGraphPtr updatePlaces(Stamp now, bool force = false);

  /// The whole mesh, world frame.
  Mesh extractMesh() { return background_.extractMesh(); }
  const mapping::BackgroundMap& background() const { return background_; }
  /// Null unless occupancy/enabled.
  mapping::OccupancyMap* occupancy() { return occupancy_.get(); }
  const mapping::OccupancyMap* occupancy() const { return occupancy_.get(); }
  const mapping::DepthFilterCounters& depthFilterCounters() const {
    return depth_filter_.counters();
  }

 private:
  BackgroundFusionConfig config_;
  mapping::DepthFilter depth_filter_;
  mapping::BackgroundMap background_;
  mapping::BackgroundMap free_space_;
  std::unique_ptr<mapping::OccupancyMap> occupancy_;
  places::PlaceExtractor places_;
  std::vector<mapping::GridIndex> changed_blocks_;  ///< of free_space_ since the last place graph
  std::optional<Stamp> last_places_;
};

}  // namespace tsg::pipeline
