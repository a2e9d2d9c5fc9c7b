// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "task_scene_graph/core/box.h"
#include "task_scene_graph/core/embedding.h"
#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/core/id.h"
#include "task_scene_graph/core/mesh.h"
#include "task_scene_graph/core/oriented_box.h"
#include "task_scene_graph/core/shared_embedding.h"
#include "task_scene_graph/core/stamp.h"

namespace tsg {

/// One segment of one frame that belongs to a track.
struct Observation {
  Stamp stamp;
  std::uint16_t segment = 0;  ///< label in that frame's label image
};

/// From where a track was seen.
struct ViewStatistics {
  Observation best;               ///< most pixels; a view that the image border cuts counts half
  std::uint32_t best_pixels = 0;  ///< with valid depth in range, in that view
  double mean_distance_m = 0.0;   ///< from the camera to the middle of what it saw
  double min_distance_m = 0.0;    ///< ... of the nearest view
  double spread_rad = 0.0;        ///< largest angle between a direction of view and the first
};

/// A track that has ended: the same object seen in several frames [Clio24, Sec. IV-A].
struct Track {
  TrackId id;
  Stamp first_seen;
  Stamp last_seen;
  Embedding embedding;  ///< mean over all embedded observations; empty if none was embedded
  std::vector<Observation> observations;  ///< by time
  ViewStatistics views;
};

/// What the tracker says of one segmented frame.
struct TrackedFrame {
  Stamp stamp;
  std::vector<TrackId> segment_tracks;  ///< S, entry s-1 = track of segment s, invalid = none
  std::vector<TrackId> live;  ///< tracks alive after this frame, ascending; their frames are needed
  std::vector<Track> finished;  ///< tracks that ended with this frame, ascending by id
  /// Live tracks as they would be if they ended now, ascending by id: some, now and then, or, if
  /// `is_snapshot`, all that can give a primitive.
  std::vector<Track> provisional{};
  bool is_snapshot = false;  ///< somebody waits for the primitives of `provisional`
};

/// A task-agnostic object primitive x_i: one finished track, reconstructed [Clio24, Sec. IV-A].
/// Immutable; a provisional one is of a track that still lives, and is replaced by one of the same
/// id.
struct ObjectPrimitive {
  PrimitiveId id;
  TrackId track;
  Mesh mesh;                 ///< world frame
  Aabb box;                  ///< world frame, metres
  OrientedBox oriented_box;  ///< upright, of least footprint; world frame
  Embedding embedding;
  Stamp first_seen;
  Stamp last_seen;
  std::uint32_t num_observations = 0;
  ViewStatistics views;
  ColorImage thumbnail;  ///< the best view's surroundings, RGB; empty if its frame was gone
  bool is_provisional = false;
};

using ObjectPrimitivePtr = std::shared_ptr<const ObjectPrimitive>;

/// A sphere of free space around a point of the generalised Voronoi diagram.
struct Place {
  PlaceId id;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< world frame
  double clearance_m = 0.0;                              ///< distance to the nearest obstacle
  SharedEmbedding embedding;    ///< mean image embedding of the views that see it; empty if none
  std::uint32_t num_views = 0;  ///< how many views entered the mean
};

/// Free passage between two places, a < b.
struct PlaceEdge {
  PlaceId a;
  PlaceId b;
  double clearance_m = 0.0;  ///< smallest clearance along the straight line
};

struct PlaceGraph {
  Stamp stamp;
  std::vector<Place> places;     ///< ascending by id
  std::vector<PlaceEdge> edges;  ///< ascending by (a, b)
};

using PlaceGraphPtr = std::shared_ptr<const PlaceGraph>;

}  // namespace tsg
