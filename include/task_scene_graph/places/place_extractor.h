// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/container/flat_map.hpp>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/mapping/tsdf_volume.h"
#include "task_scene_graph/places/ground_plan.h"
#include "task_scene_graph/places/place_memory.h"
#include "task_scene_graph/places/places_config.h"
#include "task_scene_graph/places/view_database.h"
#include "task_scene_graph/places/voxel_map.h"

namespace tsg::places {

/// What a PlaceExtractor has done since it was made.
struct PlaceCounters {
  std::uint64_t updates = 0;
  std::uint64_t views = 0;          ///< taken in
  std::uint64_t ignored_views = 0;  ///< see PlaceExtractor::addView
  std::uint64_t forgotten_views = 0;
  std::uint64_t places_created = 0;
  std::uint64_t places_removed = 0;
};

class PlaceLayers;

/// Turns observed free space into a graph of places with semantic features [Clio24, Sec. IV-A;
/// Hydra22]: distance field -> generalised Voronoi diagram -> sparse graph; each place's embedding
/// is the weighted mean of the image embeddings of all views that see it (ViewWeighting). Results
/// do not depend on the order of changed blocks nor on any thread count (there is one thread), and
/// the graph is that of one update with all blocks. docs/places.md tells how places are found. Not
/// thread-safe.
///
/// deviation: Hydra's field is three-dimensional, so the nearest surface is mostly floor or
/// ceiling, places hover at the height of the ceiling's middle over tables and sofas, and a camera
/// that sees no ceiling leaves the middle of a room empty. By default clearance is measured
/// horizontally, over observed floor, to whatever stands in the way of a body (FreeSpaceKind);
/// `volume` is Hydra's way. Open space that the diagram leaves empty (beside unseen space there is
/// only one obstacle to be near to) gets places as well (fill_distance_m).
/// deviation: upstream knows what was seen only; here the way of the body that carries the camera
/// is free space too, and places along it are joined. deviation: upstream drops the voxels outside
/// the active window; here they are kept, off the window, as an own copy (2 kB per 8^3 block), so
/// that a revisit goes on where the last visit ended. deviation: upstream has no occlusion test;
/// here a view counts only if the place is not behind the measured depth.
class PlaceExtractor {
 public:
  /// @throws config::ConfigError naming every field out of range.
  explicit PlaceExtractor(const PlacesConfig& config);
  ~PlaceExtractor();
  PlaceExtractor(PlaceExtractor&&);
  PlaceExtractor& operator=(PlaceExtractor&&);

  /// Takes in the changed blocks of a carved volume (distance > 0 = free, weight 0 = unknown; a
  /// block that is no longer there is remembered as it was) and brings the graph up to date. A
  /// place keeps its id while a place remains within one cell of where it was.
  /// @throws std::invalid_argument if the voxel size differs from that of earlier calls.
  /// O(changed voxels + free space within max_distance_m of them), whatever the map's extent.
  void update(const mapping::TsdfVolume& free_space,
              const std::vector<mapping::GridIndex>& changed_blocks, Stamp stamp);

  /// Takes in where the camera was when a frame that is in the volume was taken: the way of the
  /// body that carries it. In the order of the frames. O(1).
  void addPose(const CameraPose& pose);

  /// Takes in one view; places that appear later get it too, as long as it is remembered
  /// (max_views). Ignored and counted: an embedding that is empty, zero, not finite or of another
  /// size than before; a pose that is not finite; a depth image whose type or size is wrong.
  /// O(pixels + places).
  void addView(const RgbdFrame& frame, const Embedding& image_embedding);

  /// The graph as of the last update, with the features of all views so far. Embeddings that have
  /// not changed are shared with the graphs given before. O(places).
  PlaceGraph graph() const;

  /// The floors as of the last update; empty for `volume`. Copy it to keep it (a copy shares
  /// tiles).
  const GroundPlan& plan() const;

  const PlaceCounters& counters() const { return counters_; }

  /// What to go on from later: graph() and all that follows are the same then. O(map).
  PlaceMemory memory() const;
  /// Goes on from there instead of from what was seen so far. Places that come out where one was
  /// keep its id and its views; with the configuration of before these are all. O(map).
  /// @throws std::invalid_argument naming both if the voxel size is not `voxel_size_m`, that of the
  /// volume that is given to update(); nothing has changed then.
  void restore(const PlaceMemory& memory, double voxel_size_m);

 private:
  /// A place, whose embedding is the mean of its views: another one whenever these change, so that
  /// graphs share what has not changed.
  class PlaceState {
   public:
    Place place;
    mapping::GridIndex key = mapping::GridIndex::Zero();  ///< voxel in which it lies
    std::vector<PlaceEdge> edges;                         ///< to places of larger id, ascending

    const ViewSum& views() const { return views_; }
    void setViews(ViewSum sum);
    /// Adds the view if it sees the place.
    void addView(const ViewDatabase& database, const View& view);

   private:
    ViewSum views_;
  };
  /// Places that went and places that came, with their ids once they are matched.
  struct Changes {
    std::vector<PlaceState> removed;
    std::vector<PlaceState> added;
  };

  Changes findChanges(const std::vector<mapping::GridIndex>& touched);
  void matchIds(Changes& changes);
  void addPlaces(const Changes& changes);
  void insertPlace(PlaceState state);
  PlaceState removePlace(PlaceId id);
  void updateEdges(const std::vector<mapping::GridIndex>& touched);
  mapping::GridIndex computeCube(const Eigen::Vector3d& p_world) const;
  void rememberPlaces(const PlaceMemory& memory, Changes& changes);

  PlacesConfig config_;
  VoxelMap voxels_;
  std::unique_ptr<PlaceLayers> layers_;
  ViewDatabase views_;
  /// In one row, as all are gone through for graph(); new ones come at its end.
  boost::container::flat_map<PlaceId, std::unique_ptr<PlaceState>> places_;
  std::unordered_map<mapping::GridIndex, PlaceId, mapping::GridIndexHash> id_of_key_;
  /// Places by the cube in which they lie, so that a view is shown to those around it only.
  std::unordered_map<mapping::GridIndex, std::vector<PlaceId>, mapping::GridIndexHash> cubes_;
  Stamp stamp_;
  std::uint64_t next_id_ = 1;
  Eigen::Index embedding_size_ = 0;  ///< 0 until the first view
  PlaceCounters counters_;
};

}  // namespace tsg::places
