// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "task_scene_graph/map/map.h"
#include "task_scene_graph/places/places_config.h"

namespace tsg::map {

/// Largest tilt of a transform between two maps: objects stand upright and floors are level.
constexpr double kMaxTilt_rad = 5.0 * 3.14159265358979323846 / 180.0;

/// By how much a motion tilts what is vertical [rad], 0 to pi.
double computeTilt(const Pose& motion);

/// How two maps become one.
struct MergeOptions {
  Pose T_a_b = Pose::Identity();    ///< from `b`'s coordinates to `a`'s; upright
  bool is_transform_given = false;  ///< else both must be in the same frame
  places::PlacesConfig places;      ///< for the places of both together
  std::string name_b;               ///< of `b`, for the record
};

/// Clusters all primitives and places of a map anew, as its tasks and settings say. Clusters keep
/// their ids where the same members are together. @throws std::invalid_argument as
/// restoreBuilder().
void recluster(Map& map);

/// Two maps as one, in the coordinates of `a`, with its tasks, settings and ids.
///
/// `b`'s primitives and places get ids above all of `a`'s; MapSource says which and from where,
/// also for what `b` itself was merged from. All primitives are clustered anew, so that what both
/// saw is one object; `a`'s objects keep their ids. Free space of `b` fills what `a` has not
/// observed, and places are found in both together. Of `b`'s mesh, triangles at most a voxel from
/// `a`'s are left out. Poses of `b` with a stamp that `a` has too are left out of the trajectory.
/// O((primitives + places) log + voxels + vertices).
/// @throws std::invalid_argument naming both values if model set, size of embeddings or voxel sizes
/// differ; the frames do and no transform is given; or the transform tilts by more than 5 degrees.
Map mergeMaps(const Map& a, const Map& b, const MergeOptions& options);

}  // namespace tsg::map
