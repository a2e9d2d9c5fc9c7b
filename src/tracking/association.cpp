// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/tracking/association.h"

#include <algorithm>
#include <tuple>
#include <unordered_set>

namespace tsg::tracking {

std::vector<Candidate> assignGreedily(std::vector<Candidate> candidates) {
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return std::make_tuple(-a.iou, a.track, a.segment) <
           std::make_tuple(-b.iou, b.track, b.segment);
  });
  std::unordered_set<std::size_t> taken_segments;
  std::unordered_set<std::size_t> taken_tracks;
  std::vector<Candidate> accepted;
  for (const Candidate& candidate : candidates) {
    if (taken_segments.count(candidate.segment) > 0 || taken_tracks.count(candidate.track) > 0) {
      continue;
    }
    taken_segments.insert(candidate.segment);
    taken_tracks.insert(candidate.track);
    accepted.push_back(candidate);
  }
  return accepted;
}

}  // namespace tsg::tracking
