// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/mapping/tsdf_volume.h"

namespace tsg::mapping {

/// Parameters of the occupancy map; probabilities as in [Hornung et al. 2013].
struct OccupancyConfig {
  bool enabled = false;
  double resolution_m = 0.1;
  double min_range_m = 0.3;
  double max_range_m = 5.0;
  int pixel_stride = 4;
  double hit_probability = 0.7;
  double miss_probability = 0.4;
  double clamp_min_probability = 0.12;
  double clamp_max_probability = 0.97;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("enabled", self.enabled, {}, "", "keep an OctoMap of the frames too");
    v.field("resolution_m", self.resolution_m, {0.01, 2.0}, "m", "side of the smallest voxel");
    v.field("min_range_m", self.min_range_m, {0.0, 100.0}, "m",
            "readings nearer than this, along the ray, are ignored");
    v.field("max_range_m", self.max_range_m, {0.1, 100.0}, "m",
            "readings farther than this, along the ray, free the space up to here");
    v.field("pixel_stride", self.pixel_stride, {1, 64}, "px",
            "every so many columns and rows are read");
    v.field("hit_probability", self.hit_probability, {0.5, 0.999}, "",
            "that a voxel is occupied where a ray ends");
    v.field("miss_probability", self.miss_probability, {0.001, 0.5}, "",
            "that a voxel is occupied where a ray passes");
    v.field("clamp_min_probability", self.clamp_min_probability, {0.001, 0.49}, "",
            "no voxel is freer than this, so that it can become occupied again");
    v.field("clamp_max_probability", self.clamp_max_probability, {0.51, 0.999}, "",
            "no voxel is more occupied than this");
  }
};

enum class Occupancy { kUnknown, kFree, kOccupied };

/// The voxel with index i reaches from i * resolution_m to (i + 1) * resolution_m on each axis.
struct OccupancyVoxel {
  GridIndex index;
  bool is_occupied = false;  ///< else free
};

/// A cube of the octree whose voxels all have the same occupancy; world frame.
struct OccupancyLeaf {
  Eigen::Vector3d center_m;
  double side_m = 0.0;
  bool is_occupied = false;  ///< else free
};

struct OccupancyCounters {
  std::size_t frames_integrated = 0;
  std::size_t frames_without_depth = 0;  ///< no valid reading in range; the map is unchanged
  std::size_t readings_out_of_tree = 0;  ///< farther than 32,768 voxels from the world's origin
};

/// Free, occupied and unknown space in an octree, with the OctoMap library [Hornung et al. 2013].
///
/// Of the readings of a frame that fall into the same voxel, one ray is cast, from the camera to
/// the voxel's centre. Each voxel changes at most once per frame: it is a hit if a ray ends in it,
/// else a miss if one passes. Log-odds add up and are clamped. Not thread-safe.
class OccupancyMap {
 public:
  /// @throws config::ConfigError if a value is out of range or min_range_m is not below
  /// max_range_m.
  explicit OccupancyMap(const OccupancyConfig& config);
  /// Of the tree; O(nodes).
  OccupancyMap(const OccupancyMap& other);
  OccupancyMap(OccupancyMap&&) noexcept;
  OccupancyMap& operator=(OccupancyMap&&) noexcept;
  ~OccupancyMap();

  /// Reads a file of OctoMap's with probabilities (`.ot`), to go on from. None of it counts as
  /// changed. @throws std::runtime_error naming the file if it is not there, is no such file, or
  /// has another resolution than `config` (names both); as the constructor.
  static OccupancyMap read(const std::filesystem::path& path, const OccupancyConfig& config);

  /// Adds the voxels of another map that are unknown here, at the places to which `T_this_other`
  /// brings their centres. O(voxels of the other). @throws std::invalid_argument naming both if the
  /// resolutions differ.
  void addUnknown(const OccupancyMap& other, const Pose& T_this_other);

  /// The map with its voxels moved: blocks of 8^3 each rigidly, as their middle does, resampled to
  /// the nearest voxel, with their probabilities. Of two that come to lie in one voxel, the one
  /// more likely occupied stays. Nothing counts as changed. O(voxels).
  /// @param motion  how what is at a position (world, metres) moves: p_new = T_new_old * p_old
  OccupancyMap moved(const std::function<Pose(const Eigen::Vector3d& p_m)>& motion) const;

  const OccupancyConfig& config() const { return config_; }
  const OccupancyCounters& counters() const { return counters_; }

  /// Casts the rays of a frame; false if none of its readings could be used.
  /// O(readings + rays * max_range_m / resolution_m).
  /// @throws std::invalid_argument if the frame breaks RgbdFrame::validate().
  bool integrate(const RgbdFrame& frame);

  /// Unknown outside the tree. @param point_m world frame.
  Occupancy at(const Eigen::Vector3d& point_m) const;
  /// Of the voxel with this index. O(1).
  Occupancy atVoxel(const GridIndex& index) const;

  /// The voxels that are free, occupied or unknown otherwise than at the call before, as they are
  /// now; ascending by (z, y, x). What changed and changed back is not among them, unless it was
  /// unknown.
  std::vector<OccupancyVoxel> takeChanges();

  /// All known space, in the order of the tree. O(leaves).
  std::vector<OccupancyLeaf> leaves() const;
  /// All known voxels, ascending by (z, y, x). O(voxels).
  std::vector<OccupancyVoxel> voxels() const;

  /// The tree without a file header, as octomap_msgs/Octomap holds it: free, occupied and unknown
  /// only (`binary`), or with probabilities.
  std::string serialize(bool binary) const;

  /// The tree as a file of OctoMap's: free, occupied and unknown only (`.bt`, binary), or with
  /// probabilities (`.ot`). O(nodes).
  std::string serializeFile(bool binary) const;

  /// Writes serializeFile(), `.ot` or `.bt` by the path. The file is there whole or not at all.
  /// @throws std::invalid_argument for another extension, std::runtime_error as
  /// writeFileAtomically().
  void write(const std::filesystem::path& path) const;

 private:
  struct Tree;

  void addVoxel(const GridIndex& voxel, const OccupancyMap& other, const GridIndex& from);
  void collectRays(const RgbdFrame& frame);
  void addRay(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& end_m);

  OccupancyConfig config_;
  OccupancyCounters counters_;
  std::unique_ptr<Tree> tree_;
};

}  // namespace tsg::mapping
