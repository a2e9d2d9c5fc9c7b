// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace tsg::tracking {

/// A segment that may continue a track: cosine and IoU are above their thresholds.
struct Candidate {
  std::size_t segment = 0;  ///< index of the segment in its frame
  std::size_t track = 0;    ///< index of the track; smaller = older
  double iou = 0.0;
};

/// Greedy assignment by highest IoU, each segment and each track at most once; equal IoU goes to
/// the smaller track, then the smaller segment, so the result does not depend on the input's order.
/// @returns the accepted candidates, best first. O(C log C). [Clio24, Sec. IV-A]
std::vector<Candidate> assignGreedily(std::vector<Candidate> candidates);

}  // namespace tsg::tracking
