// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/mapping/block_selector.h"
#include "task_scene_graph/mapping/depth_buffer.h"
#include "task_scene_graph/mapping/tsdf_volume.h"

namespace tsg::mapping {

enum class Weighting {
  /// fx fy (voxel / z)^2 / z^2: pixels per voxel over the variance of depth. z is the depth of the
  /// voxel, not of the reading, so that a far wall frees the space before it as surely as a near
  /// one.
  kPixelArea,
  kConstant,  ///< 1
};

/// Parameters of projective TSDF integration. `deviation:` the authors' map has 0.10 m voxels and a
/// truncation of 2.5 voxels; here 0.05 m and 4 voxels, because the projective distance of a surface
/// seen at angle a grows with 1 / cos(a) and voxels beyond the truncation are lost behind it.
struct IntegratorConfig {
  double voxel_size_m = 0.05;
  double truncation_m = 0.2;
  double min_range_m = 0.3;
  double max_range_m = 5.0;
  bool carve_free_space = false;
  bool with_color = true;
  Weighting weighting = Weighting::kPixelArea;
  double drop_off_start_voxels = 1.0;
  double max_weight = 1e5;
  int num_threads = 2;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("voxel_size_m", self.voxel_size_m, {0.001, 2.0}, "m", "side of a voxel");
    v.field("truncation_m", self.truncation_m, {0.002, 10.0}, "m",
            "distances are clamped to this; at least 2 voxels");
    v.field("min_range_m", self.min_range_m, {0.0, 100.0}, "m",
            "nearer depth readings are ignored");
    v.field("max_range_m", self.max_range_m, {0.1, 100.0}, "m",
            "farther depth readings are ignored");
    v.field("carve_free_space", self.carve_free_space, {}, "",
            "also update voxels between the camera and the truncation band, up to max_range_m "
            "where the reading lies beyond");
    v.field("with_color", self.with_color, {}, "", "blend colours into voxels near the surface");
    v.choice("weighting", self.weighting,
             {{"pixel_area", Weighting::kPixelArea}, {"constant", Weighting::kConstant}},
             "weight of a reading for a voxel, by the voxel's depth");
    v.field("drop_off_start_voxels", self.drop_off_start_voxels, {0.0, 100.0}, "voxels",
            "behind the surface, weights fall linearly from here to 0 at the truncation; less "
            "than the truncation");
    v.field("max_weight", self.max_weight, {1e-3, 1e9}, "", "the weight of a voxel stays below");
    v.field("num_threads", self.num_threads, {1, 256}, "", "threads of one integration");
  }
};

enum class IntegrationStatus {
  kIntegrated,
  kNoValidDepth,    ///< no reading of the frame is valid and in range; the volume is unchanged
  kPoseOutOfRange,  ///< farther than 1000 km from the origin; the volume is unchanged
};

struct IntegrationResult {
  IntegrationStatus status = IntegrationStatus::kIntegrated;
  /// Blocks in which a voxel near a surface changed or a voxel was seen for the first time:
  /// everything derived from other blocks is still right. Ascending by (z, y, x).
  std::vector<GridIndex> changed_blocks;
  std::vector<GridIndex> observed_blocks;  ///< all with an updated voxel, ascending by (z, y, x)
  std::vector<GridIndex> archived_blocks;  ///< whose voxels were dropped (BackgroundMap only)
  std::size_t num_new_blocks = 0;
  std::size_t num_updated_voxels = 0;
};

/// Integrates posed RGB-D frames into a TSDF, one voxel at a time [Curless and Levoy 1996].
///
/// A voxel centre at depth z that projects to a pixel with depth reading d gets the distance along
/// its ray, s = (d - z) |ray|, |ray| = sqrt(1 + x^2 + y^2) at normalised coordinates (x, y). Voxels
/// with s <= -truncation stay; s is clamped to +truncation. The reading's weight is
///     w = w_z                                              for s >= -drop_off
///     w = w_z (truncation + s) / (truncation - drop_off)   behind
/// with w_z by `Weighting`, and (distance, weight) becomes the weighted mean, the weight capped at
/// max_weight. Colours blend with the same shares where |s| < truncation; the first colour of a
/// voxel is taken as it is. All voxels of the blocks that the truncation band meets are
/// updated. `deviation:` depth is read at the nearest pixel; the authors interpolate adaptively.
///
/// Cost: one pass over the image plus O(voxels of the selected blocks). Frames are independent: a
/// jump of the pose only means that other blocks are updated. The same bits result for any number
/// of threads. Not thread-safe (keeps scratch memory).
class TsdfIntegrator {
 public:
  /// @throws config::ConfigError if a value is out of range, the truncation is below 2 voxels or
  /// not above the drop-off, or min_range_m is not below max_range_m.
  explicit TsdfIntegrator(const IntegratorConfig& config);

  const IntegratorConfig& config() const { return config_; }

  /// @throws std::invalid_argument if the frame breaks RgbdFrame::validate() or the volume's voxel
  /// size is not the configured one.
  IntegrationResult integrate(const RgbdFrame& frame, TsdfVolume& volume);

 private:
  /// What keeps a frame from being integrated; else reads its depth.
  IntegrationStatus readDepth(const RgbdFrame& frame);
  /// The blocks that the frame can change, made where there were none; ascending by (z, y, x).
  std::vector<TsdfBlock*> allocateBlocks(const RgbdFrame& frame, TsdfVolume& volume);

  IntegratorConfig config_;
  DepthBuffer depth_;
  BlockSelector selector_;
};

/// Ascending by (z, y, x), the order in which blocks are reported.
bool isBefore(const GridIndex& a, const GridIndex& b);

}  // namespace tsg::mapping
