// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/mapping/depth_filter.h"
#include "task_scene_graph/mapping/frame_buffer.h"

namespace tsg::mapping {

/// Parameters of object reconstruction; defaults of the authors' "fine" configuration where not
/// said otherwise. min_observations is theirs put plainly: a confidence above 0.5 needs four
/// observations.
/// deviation: their readings end at 4 m and their share is 0.5. In large rooms things are seen from
/// farther off only, and masks that spill over at every view take in the neighbours' surface.
struct ObjectConfig {
  int min_observations = 4;
  int min_pixels = 20;
  double min_range_m = 0.3;
  double max_range_m = 8.0;
  double resolution_fraction = 0.03;
  double min_voxel_size_m = 0.005;
  double truncation_voxels = 2.0;
  double min_object_share = 0.65;
  int min_voxel_observations = 2;
  double min_part_share = 0.5;
  double min_volume_m3 = 0.0;
  double max_volume_m3 = 8.0;
  int max_frames = 40;
  int thumbnail_px = 96;
  DepthFilterConfig depth_filter;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("min_observations", self.min_observations, {1, 1e6}, "",
            "a track with fewer observations gives no primitive");
    v.field("min_pixels", self.min_pixels, {1, 1e9}, "px",
            "observations with fewer pixels of valid depth are left out");
    v.field("min_range_m", self.min_range_m, {0.0, 100.0}, "m",
            "nearer depth readings are ignored");
    v.field("max_range_m", self.max_range_m, {0.1, 100.0}, "m",
            "farther depth readings are ignored");
    v.field("resolution_fraction", self.resolution_fraction, {0.002, 1.0}, "",
            "voxel size over the largest side of the object's extent");
    v.field("min_voxel_size_m", self.min_voxel_size_m, {0.0005, 1.0}, "m",
            "voxels are not made smaller than this");
    v.field("truncation_voxels", self.truncation_voxels, {2.0, 100.0}, "voxels",
            "truncation of the object's TSDF");
    v.field("min_object_share", self.min_object_share, {0.0, 1.0}, "",
            "a voxel belongs to the object if this share of its observations has its label");
    v.field("min_voxel_observations", self.min_voxel_observations, {1, 1e6}, "",
            "a voxel seen less often near a surface counts as free space");
    v.field(
        "min_part_share", self.min_part_share, {0.0, 1.0}, "",
        "surface apart from an object's largest part is kept if it has this share of that part's "
        "points; 0 = all");
    v.field("min_volume_m3", self.min_volume_m3, {0.0, 1e6}, "m^3",
            "objects with a smaller box are rejected");
    v.field("max_volume_m3", self.max_volume_m3, {0.0, 1e6}, "m^3",
            "objects with a larger box are rejected");
    v.field("max_frames", self.max_frames, {1, 1e6}, "frames",
            "of a track with more observations, this many evenly spaced ones are used");
    v.field("thumbnail_px", self.thumbnail_px, {0, 4096}, "px",
            "largest side of the picture of the object's best view; 0 = no picture");
    v.group("depth_filter", self.depth_filter);
  }
};

enum class ReconstructionStatus {
  kReconstructed,
  kTooFewObservations,  ///< the track has fewer than min_observations
  kNoFrames,            ///< no frame of the track is in the buffer any more
  kNoDepth,             ///< no observation has min_pixels pixels of valid depth
  kTooSmall,            ///< box below min_volume_m3
  kTooLarge,            ///< box above max_volume_m3
  kEmptyMesh,           ///< no surface was left after the object/background decision
  kBadFrames,           ///< a frame or label image broke its conditions (ReconstructionPool only)
};

/// "reconstructed", "too few observations", ... for messages and counters.
const char* toString(ReconstructionStatus status);

struct ReconstructionResult {
  ReconstructionStatus status = ReconstructionStatus::kEmptyMesh;
  std::shared_ptr<ObjectPrimitive> primitive;  ///< null unless reconstructed
};

/// Reconstructs the object of a finished track from the track's own frames [Clio24, Sec. IV-A].
///
/// 1. The extent is the box of all 3D points of the track's label pixels after the depth filter,
///    without small parts that lie apart (keepMainPart: masks spill over silhouettes); the voxel
///    size is max(resolution_fraction * largest side, min_voxel_size_m).
/// 2. Every frame is integrated (all its pixels, formulas of TsdfIntegrator) into the blocks that
///    the truncation band of any label pixel meets. Per voxel it is counted how often a reading
///    within the truncation had the object's label and how often another.
/// 3. Voxels at or behind the surface with object / (object + other) < min_object_share, and all
///    that were counted less than min_voxel_observations times, become free space.
/// 4. Marching cubes; the boxes are the AABB and the upright box of least footprint of the mesh's
///    vertices.
///
/// `deviation:` the authors count an observation at any distance in front of a surface, integrate
/// every frame of a track, however many there are, and keep parts that lie apart.
///
/// A pure function of its arguments: the same bits each time; thread-safe.
/// O(frames * (pixels of the object's surroundings + voxels of its surface)).
class ObjectReconstructor {
 public:
  /// @throws config::ConfigError if a value is out of range or min_range_m not below max_range_m.
  explicit ObjectReconstructor(const ObjectConfig& config);

  const ObjectConfig& config() const { return config_; }

  ReconstructionResult reconstruct(const Track& track, const FrameBuffer& frames,
                                   PrimitiveId id) const;

  /// The same from frames collected before, one per observation; null pointers are left out.
  /// @throws std::invalid_argument if there is not one entry per observation, or a frame and its
  /// label image differ in size.
  ReconstructionResult reconstruct(const Track& track, const std::vector<SegmentedFrame>& frames,
                                   PrimitiveId id) const;

 private:
  ObjectConfig config_;
};

}  // namespace tsg::mapping
