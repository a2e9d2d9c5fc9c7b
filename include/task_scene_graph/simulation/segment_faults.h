// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/core/frame.h"

namespace tsg::simulation {

/// What segmenters and image encoders do to segments. All zeros (and a cosine of 1): nothing.
struct SegmentFaultsConfig {
  double view_cosine = 1.0;
  double small_crop_px = 0.0;
  double dropped = 0.0;
  double merged = 0.0;
  double split = 0.0;
  int eroded_px = 0;
  int patches = 0;
  int seed = 1;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("view_cosine", self.view_cosine, {0.1, 1.0}, "",
            "expected cosine between the embeddings of two large views of one thing");
    v.field("small_crop_px", self.small_crop_px, {0.0, 1e6}, "px",
            "segments of this size have twice the noise's variance, smaller ones more");
    v.field("dropped", self.dropped, {0.0, 1.0}, "", "share of segments that a frame misses");
    v.field("merged", self.merged, {0.0, 1.0}, "",
            "share of segments that become one with the neighbour of the longest border");
    v.field("split", self.split, {0.0, 1.0}, "",
            "share of segments cut in two across their longer side");
    v.field("eroded_px", self.eroded_px, {0, 50}, "px",
            "pixels this near to a segment's border are of no segment");
    v.field("patches", self.patches, {0, 100}, "",
            "pieces of what is no segment (walls, floor) that become segments, per frame of three "
            "segments or more");
    v.field("seed", self.seed, {0, 1000000000}, "", "other faults of the same kind");
  }

  /// As FastSAM and CLIP give them on clean images, and as they do on bad ones.
  static SegmentFaultsConfig makeClipLike();
  static SegmentFaultsConfig makeHard();
};

/// Spoils segments made from true labels so that they resemble a network's. The same segmentation
/// gives the same faults; frames are told apart by their stamps. Thread-safe.
///
/// Embeddings: e' = (e + s n) / |e + s n| with n of independent normal numbers, E|n|^2 = 1 and s^2
/// = (1 / view_cosine - 1)(1 + small_crop_px / pixels): two views of one thing then have a cosine
/// of about 1 / (1 + s^2), and the mean of many views is the thing's own embedding again.
class SegmentFaults {
 public:
  /// @throws config::ConfigError naming every field out of range.
  explicit SegmentFaults(const SegmentFaultsConfig& config);

  /// Segments numbered from 1, without gaps. O(pixels * eroded_px + segments * D).
  Segmentation apply(const Segmentation& segmentation) const;

 private:
  SegmentFaultsConfig config_;
};

}  // namespace tsg::simulation
