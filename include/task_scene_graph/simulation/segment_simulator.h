// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/simulation/apartment.h"
#include "task_scene_graph/simulation/embedding_space.h"
#include "task_scene_graph/simulation/renderer.h"

namespace tsg::simulation {

struct SegmentConfig {
  int min_pixels = 80;
  double dropout = 0.03;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("min_pixels", self.min_pixels, {1.0, 1e6}, "px", "smaller segments are not found");
    v.field("dropout", self.dropout, {0.0, 1.0}, "", "share of segments that a frame misses");
  }
};

/// Segments made from the true labels, in place of a segmenter: furniture falls apart into its
/// parts (seat, backrest, legs: the same parts in every view), small things are one segment each;
/// walls, floor and ceiling are no segments. Embeddings come from EmbeddingSpace with noise per
/// view; the image embedding mixes the phrases of the rooms by the pixels that show them.
/// Deterministic in the apartment's seed and the frame number.
class SegmentSimulator {
 public:
  /// The apartment must outlive this. @throws config::ConfigError
  SegmentSimulator(const Apartment& apartment, const SegmentConfig& config);

  /// Segments by ascending part id, numbered from 1. O(pixels + segments * D).
  Segmentation segment(const RenderedView& view, Stamp stamp, std::int64_t frame) const;

  /// The part's embedding in the given frame; part ids as in RenderedView::parts, not 0.
  Embedding embedPart(std::uint16_t part, std::int64_t frame) const;

 private:
  Embedding embedImage(const RenderedView& view, std::int64_t frame) const;

  const Apartment& apartment_;
  SegmentConfig config_;
  EmbeddingSpace space_;
};

}  // namespace tsg::simulation
