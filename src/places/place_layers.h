// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "floor_map.h"
#include "place_cells.h"
#include "place_links.h"
#include "space_map.h"
#include "task_scene_graph/places/ground_plan.h"
#include "task_scene_graph/places/voxel_map.h"
#include "way_map.h"

namespace tsg::places {

/// From voxels and the body's way to the graph of places, layer by layer:
///   voxels, way -> floors -> cells -> clearance -> Voronoi cells -> places -> edges
/// Each layer is a function of the one below in a bounded neighbourhood, and hands on which of its
/// tiles differ, so an update costs what changed and its surroundings, and its result is that of
/// one update with everything.
class PlaceLayers {
 public:
  explicit PlaceLayers(const PlacesConfig& config)
      : config_(config),
        way_(config),
        floors_(config),
        space_(config),
        cells_(config),
        links_(config) {}

  void addPose(const CameraPose& pose) { way_.addPose(pose); }

  /// @param changed  tiles whose voxels changed
  /// @returns as PlaceLinks::update()
  CellSet update(const VoxelMap& voxels, const TileSet& changed);
  /// From scratch, along the same way. O(map).
  CellSet updateAll(const VoxelMap& voxels, const WayMap& way);

  const WayMap& way() const { return way_; }
  const SpaceMap& space() const { return space_; }
  const PlaceCells& cells() const { return cells_; }
  const PlaceLinks& links() const { return links_; }
  const GroundPlan& plan() const { return plan_; }

 private:
  CellSet propagate(const VoxelMap& voxels, const TileSet& changed);

  PlacesConfig config_;
  WayMap way_;
  FloorMap floors_;
  SpaceMap space_;
  GroundPlan plan_;
  PlaceCells cells_;
  PlaceLinks links_;
};

}  // namespace tsg::places
