// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/mapping/tsdf_volume.h"
#include "task_scene_graph/places/ground_plan.h"
#include "task_scene_graph/places/view_database.h"

namespace tsg::places {

/// Where a camera was.
struct CameraPose {
  Stamp stamp;
  Pose T_world_camera = Pose::Identity();
};

/// The way of the body that carries the camera.
struct WayMemory {
  struct Segment {
    Eigen::Vector3d from_m;
    Eigen::Vector3d to_m;
  };
  std::vector<Segment> segments;             ///< in the order in which they were walked
  double camera_height_m = 0.0;              ///< over the ground, as the way was laid
  std::vector<std::uint32_t> height_counts;  ///< poses by the camera's height
  std::optional<CameraPose> last;            ///< the way goes on from here
  std::vector<CameraPose> waiting;           ///< not yet in the way
};

/// Signed distances of 8 x 8 x 8 voxels, x fastest; NaN: never observed.
struct VoxelBlock {
  mapping::GridIndex index = mapping::GridIndex::Zero();
  std::array<float, mapping::kBlockVoxels> distances_m{};
};

/// A place, by which it is known again.
struct RememberedPlace {
  Place place;                                          ///< without embedding: see `views`
  mapping::GridIndex key = mapping::GridIndex::Zero();  ///< voxel in which it lies
  std::optional<ViewSum> views;                         ///< none: of the views that are remembered
};

/// All that a PlaceExtractor has seen, from which another one goes on. A plain value; world frame.
struct PlaceMemory {
  double voxel_size_m = 0.0;       ///< 0: nothing was ever observed
  std::vector<VoxelBlock> blocks;  ///< each index once
  WayMemory way;
  std::vector<View> views;              ///< from the oldest on
  std::vector<RememberedPlace> places;  ///< ascending by id
  std::uint64_t next_id = 1;            ///< of a new place
  Stamp stamp;                          ///< of the last update
  GroundPlan plan;                      ///< as of the last update; follows from the rest

  bool isEmpty() const { return voxel_size_m == 0.0; }
};

/// The memory of both in the coordinates of `a`: what was observed in `a` stays, `b` adds what `a`
/// has not observed, resampled to `a`'s voxels (nearest one). Ids of `b`'s places, and where they
/// are, are kept with `id_offset` added. The plan is empty: it follows once an extractor has been
/// restored. Views count anew for all places. O(voxels + views).
/// @throws std::invalid_argument naming both if the voxel sizes differ and neither is empty.
PlaceMemory mergeMemories(const PlaceMemory& a, const PlaceMemory& b, const Pose& T_a_b,
                          std::uint64_t id_offset);

}  // namespace tsg::places
