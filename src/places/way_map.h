// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "task_scene_graph/places/place_memory.h"
#include "task_scene_graph/places/places_config.h"
#include "tiles.h"

namespace tsg::places {

/// A column that the body covered.
struct WayCell {
  int offset = 0;        ///< of the column in its tile
  double level_m = 0.0;  ///< world z of the ground under the body (`volume`: of the voxel)
  bool is_axis = false;  ///< the middle of the body was here
  /// The highest ground of the body, at most half its height above the level, while it covered the
  /// column: on stairs it stands higher a little later.
  double top_m = 0.0;
  double away_m = 0.0;  ///< the middle of the body from the column's, when it was at the level

  /// Whether that is the slope of the way and not a camera that sways.
  bool climbs(double max_step_m) const { return top_m - level_m > 0.5 * max_step_m; }
};

/// Where the body that carries the camera was: the columns that it covered, with the height of the
/// ground under it. Two poses that follow one another make a way if they are at most
/// `max_way_gap_m` and 5 s apart; one pose alone makes none, so a single wrong one leaves no trace.
class WayMap {
 public:
  explicit WayMap(const PlacesConfig& config)
      : config_(config),
        is_estimated_(config.free_space == FreeSpaceKind::kWalkable &&
                      config.camera_height_m == 0.0) {}

  /// Keeps a pose until the next update(). Poses that are not finite are ignored.
  void addPose(const CameraPose& pose);

  /// Adds the way of the poses that wait, once the camera's height is known. While it is estimated
  /// and the estimate moves by more than 0.1 m, all of the way is laid anew.
  /// @param observe  gives the heights of the ground observed around a position, in any order
  /// @returns the tiles with cells that changed. O(length of the new way).
  template <typename Observe>
  TileSet update(double voxel_size_m, Observe observe) {
    if (is_estimated_) {
      for (const CameraPose& pose : waiting_) {
        countHeight(pose, observe(pose.T_world_camera.translation()));
      }
    }
    return advance(voxel_size_m);
  }

  /// Cells of a tile by column, then level; empty if there are none.
  const std::vector<WayCell>& cellsAt(const TileIndex& tile) const;
  std::vector<TileIndex> tileIndices() const;

  /// Metres from the ground to the camera; none while it is to be estimated and no ground was seen.
  std::optional<double> cameraHeight() const;

  WayMemory memory() const;
  /// Goes on from there. O(length of the way).
  void restore(const WayMemory& memory, double voxel_size_m);

 private:
  static constexpr int kHeightBins = 60;
  static constexpr double kHeightBin_m = 0.05;

  /// Two positions that follow one another.
  struct Segment {
    Eigen::Vector3d from;
    Eigen::Vector3d to;
  };

  void countHeight(const CameraPose& pose, const std::vector<float>& ground_m);
  TileSet advance(double voxel_size_m);
  void addSegments();
  void lay(const Segment& segment, double voxel_size_m, TileSet& changed);
  void cover(const Eigen::Vector3d& position, double voxel_size_m, TileSet& changed);
  void addCell(const Column& column, double level_m, double away_m, bool is_axis,
               double voxel_size_m, TileSet& changed);

  PlacesConfig config_;
  bool is_estimated_;  ///< the camera's height
  std::vector<CameraPose> waiting_;
  std::optional<CameraPose> last_;
  std::vector<Segment> segments_;                     ///< all of the way
  std::size_t num_laid_ = 0;                          ///< of these
  double laid_height_m_ = 0.0;                        ///< of the camera, for these
  std::array<std::uint32_t, kHeightBins> heights_{};  ///< how many poses had the camera so high
  std::unordered_map<TileIndex, std::vector<WayCell>, TileIndexHash> cells_;
};

}  // namespace tsg::places
